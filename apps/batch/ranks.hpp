#pragma once
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace apps {

/// The processes that mpirun or srun has started together, numbered from 0, and short messages between them.
class Ranks {
 public:
  struct Message {
    int from = 0;
    std::string text;
  };
  virtual ~Ranks() = default;
  [[nodiscard]] virtual int rank() const = 0;
  [[nodiscard]] virtual int size() const = 0;
  /// Messages of one rank to another arrive in their order.
  virtual void send(int to, std::string_view text) = 0;
  /// The next message that has arrived; never waits.
  [[nodiscard]] virtual std::optional<Message> receive() = 0;
  /// Waits until all ranks are here; no message after this.
  virtual void finish() = 0;
};

/// How many processes mpirun (of Open MPI) or srun has started with this one, by what they leave in the environment; 1
/// without either.
[[nodiscard]] int launched_processes();

/// Joins them. MPI is loaded here and nowhere else: a program started by itself never sees it. Throws dsp::Fault
/// (usage, "batch.mpi") where the program was built without MPI, or where the launcher and its MPI do not go together.
[[nodiscard]] std::unique_ptr<Ranks> join_ranks();

/// What the module that is loaded then offers, by this name.
inline constexpr const char* join_function_name = "ardent_join_mpi";
using JoinFunction = Ranks* (*)();

}  // namespace apps
