// The one file that includes MPI: a module of its own, so that the program needs none where none is used.
#define OMPI_SKIP_MPICXX 1
#include <mpi.h>

#include "apps/batch/ranks.hpp"

namespace apps {
namespace {

class MpiRanks final : public Ranks {
 public:
  MpiRanks() {
    MPI_Init(nullptr, nullptr);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &size_);
  }
  int rank() const override { return rank_; }
  int size() const override { return size_; }
  void send(int to, std::string_view text) override {
    MPI_Send(text.data(), static_cast<int>(text.size()), MPI_CHAR, to, tag, MPI_COMM_WORLD);
  }
  std::optional<Message> receive() override {
    int arrived = 0, count = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &arrived, &status);
    if (arrived == 0) return std::nullopt;
    MPI_Get_count(&status, MPI_CHAR, &count);
    Message message{status.MPI_SOURCE, std::string(static_cast<std::size_t>(count), '\0')};
    MPI_Recv(message.text.data(), count, MPI_CHAR, message.from, tag, MPI_COMM_WORLD, MPI_STATUS_IGNORE);
    return message;
  }
  void finish() override { MPI_Finalize(); }

 private:
  static constexpr int tag = 1;
  int rank_ = 0, size_ = 1;
};

}  // namespace
}  // namespace apps

extern "C" apps::Ranks* ardent_join_mpi() {
  return new apps::MpiRanks;
}
