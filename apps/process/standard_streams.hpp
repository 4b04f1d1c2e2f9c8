#pragma once

namespace apps {

/// Takes the descriptors 0 to 2 where the program was started without them, so that no file of ours is opened there and
/// written over by messages. What is written to such a stream fails as if it were still closed. Called before anything
/// is opened.
void reserve_standard_streams();

}  // namespace apps
