#pragma once
#include <sndfile.h>

#include <memory>

namespace dsp {

using SoundHandle = std::unique_ptr<SNDFILE, int (*)(SNDFILE*)>;

/// What libsndfile calls for a SoundBytes, which is read, or a SoundOutput, which is written.
template <class File>
SF_VIRTUAL_IO* virtual_calls() {
  static const auto of = [](void* self) -> File& { return *static_cast<File*>(self); };
  static SF_VIRTUAL_IO calls{[](void* self) { return sf_count_t{of(self).size()}; },
                             [](sf_count_t offset, int whence, void* self) { return of(self).seek(offset, whence); },
                             [](void* into, sf_count_t count, void* self) {
                               if constexpr (requires { of(self).read(into, count); })
                                 return sf_count_t{of(self).read(into, count)};
                               else
                                 return sf_count_t{0};
                             },
                             [](const void* bytes, sf_count_t count, void* self) {
                               if constexpr (requires { of(self).write(bytes, count); })
                                 return sf_count_t{of(self).write(bytes, count)};
                               else
                                 return sf_count_t{0};
                             },
                             [](void* self) { return sf_count_t{of(self).tell()}; }};
  return &calls;
}

}  // namespace dsp
