#include "apps/process/interrupt.hpp"

#include <csignal>
#include <mutex>

namespace apps {
namespace {

volatile std::sig_atomic_t pending_signal = 0;  // a signal handler may touch nothing else

/// Of several threads of one program.
struct {
  std::mutex guard;
  int count = 0;
  struct sigaction before {};
} scopes;

extern "C" void remember(int signal) {
  pending_signal = signal;
  std::signal(signal, SIG_DFL);
}

}  // namespace

void install_signal_handlers() {
  struct sigaction action {};
  action.sa_handler = remember;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  struct sigaction hangup {};
  if (sigaction(SIGHUP, nullptr, &hangup) == 0 && hangup.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
}

InterruptScope::InterruptScope() {
  const std::lock_guard lock(scopes.guard);
  if (scopes.count++ > 0) return;
  struct sigaction action {};
  action.sa_handler = remember;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESTART;
  sigaction(SIGINT, &action, &scopes.before);
}

InterruptScope::~InterruptScope() {
  const std::lock_guard lock(scopes.guard);
  if (--scopes.count > 0) return;
  sigaction(SIGINT, &scopes.before, nullptr);
  pending_signal = 0;
}

void check_interrupted() {
  if (pending_signal != 0) throw Interrupted{pending_signal};
}

}  // namespace apps
