#include "apps/process/child_process.hpp"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <system_error>
#include <utility>

namespace apps {
namespace {

constexpr const char* this_executable = "/proc/self/exe";
constexpr std::size_t most_kept = 1 << 16;

struct Pipe {
  Descriptor out, in;
  Pipe() {
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) throw std::system_error(errno, std::generic_category(), "no pipe");
    out = Descriptor(ends[0]);
    in = Descriptor(ends[1]);
  }
};

/// In the child, where nothing but system calls is safe. Never returns.
[[noreturn]] void become(char* const* arguments, int out, int err, pid_t parent) {
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(1);  // it ended before the line above
  const int nothing = ::open("/dev/null", O_RDONLY);
  ::dup2(nothing, STDIN_FILENO);
  ::dup2(out, STDOUT_FILENO);
  ::dup2(err, STDERR_FILENO);
  ::execv(this_executable, arguments);
  ::_exit(127);
}

}  // namespace

ChildProcess::ChildProcess(const std::vector<std::string>& arguments) {
  std::vector<std::string> all{"ardent"};
  all.insert(all.end(), arguments.begin(), arguments.end());
  std::vector<char*> pointers;
  for (std::string& argument : all) pointers.push_back(argument.data());
  pointers.push_back(nullptr);
  Pipe out, err;
  const pid_t parent = ::getpid();
  pid_ = ::fork();
  if (pid_ < 0) throw std::system_error(errno, std::generic_category(), "no process");
  if (pid_ == 0) become(pointers.data(), out.in.number, err.in.number, parent);
  out_.descriptor = std::move(out.out);
  err_.descriptor = std::move(err.out);
  for (const Stream* stream : {&out_, &err_}) ::fcntl(stream->descriptor.number, F_SETFL, O_NONBLOCK);
}

ChildProcess::~ChildProcess() {
  for (Stream* stream : {&out_, &err_}) stream->descriptor = Descriptor();
  if (pid_ < 0) return;
  ::kill(pid_, SIGTERM);
  while (::waitpid(pid_, &status_, 0) < 0 && errno == EINTR) {
  }
}

void ChildProcess::Stream::read() {
  std::array<char, 4096> piece{};
  while (descriptor.number >= 0) {
    const ssize_t count = ::read(descriptor.number, piece.data(), piece.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 && errno == EAGAIN) return;
    if (count <= 0) {
      descriptor = Descriptor();
      return;
    }
    text.append(piece.data(), static_cast<std::size_t>(count));
    if (text.size() > 2 * most_kept) text.erase(0, text.size() - most_kept);
  }
}

bool ChildProcess::ended() {
  out_.read();
  err_.read();
  if (pid_ >= 0 && ::waitpid(pid_, &status_, WNOHANG) == pid_) {
    out_.read();
    err_.read();
    pid_ = -1;
  }
  return pid_ < 0;
}

ChildEnd ChildProcess::take() {
  ChildEnd end{.out = std::move(out_.text), .err = std::move(err_.text)};
  if (WIFSIGNALED(status_))
    end.signal = WTERMSIG(status_);
  else
    end.exit_code = WEXITSTATUS(status_);
  return end;
}

void ChildProcess::wait_for_any(const std::vector<ChildProcess*>& children, std::chrono::milliseconds longest) {
  std::vector<pollfd> descriptors;
  for (const ChildProcess* child : children)
    for (const Stream* stream : {&child->out_, &child->err_})
      if (stream->descriptor.number >= 0) descriptors.push_back({stream->descriptor.number, POLLIN, 0});
  // A child whose streams are closed is about to end.
  constexpr int soon_ms = 2;
  const bool closing = descriptors.size() < 2 * children.size();
  const int timeout = closing ? soon_ms : static_cast<int>(longest.count());
  ::poll(descriptors.data(), descriptors.size(), timeout);
}

}  // namespace apps
