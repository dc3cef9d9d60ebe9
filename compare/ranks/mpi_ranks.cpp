// The only file that includes MPI.
#include <mpi.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "compare/ranks/ranks.h"

namespace lamella {
namespace {

// Of messages: whole; the size of one in pieces; a piece.
constexpr int kWhole = 1, kSize = 2, kPiece = 3;

// Set in processes that a starter of MPI started: OpenMPI, MPICH and its kin, srun.
constexpr std::array kSigns{"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK", "MPI_LOCALNRANKS"};

class MpiRanks : public Ranks {
 public:
  MpiRanks() {
    int given = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_SERIALIZED, &given);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    MPI_Comm local = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, rank_, MPI_INFO_NULL, &local);
    MPI_Comm_size(local, &neighbours_);
    MPI_Comm_free(&local);
  }

  [[nodiscard]] int rank() const override { return rank_; }
  [[nodiscard]] int count() const override { return count_; }
  [[nodiscard]] int neighbours() const override { return neighbours_; }

  void send(int to, std::string_view bytes) override {
    if (bytes.size() <= kMessageBytes) {
      send_message(to, bytes, kWhole);
      return;
    }
    const std::uint64_t size = bytes.size();
    send_message(to, {reinterpret_cast<const char*>(&size), sizeof size}, kSize);
    for (; !bytes.empty(); bytes.remove_prefix(std::min<std::size_t>(bytes.size(), kMessageBytes)))
      send_message(to, bytes.substr(0, kMessageBytes), kPiece);
  }

  [[nodiscard]] std::optional<RankMessage> poll() override {
    for (const int tag : {kWhole, kSize}) {
      int is_there = 0;
      MPI_Status status;
      MPI_Iprobe(MPI_ANY_SOURCE, tag, MPI_COMM_WORLD, &is_there, &status);
      if (!is_there) continue;
      RankMessage message{status.MPI_SOURCE, received(status, tag)};
      if (tag == kWhole) return message;
      std::uint64_t size = 0;
      std::copy_n(message.bytes.data(), sizeof size, reinterpret_cast<char*>(&size));
      message.bytes.clear();
      while (message.bytes.size() < size) {
        MPI_Probe(message.from, kPiece, MPI_COMM_WORLD, &status);
        message.bytes += received(status, kPiece);
      }
      return message;
    }
    return std::nullopt;
  }

  [[nodiscard]] RankTraffic traffic() const override { return traffic_; }

  [[noreturn]] void abort(int status) override {
    std::fflush(nullptr);
    MPI_Abort(MPI_COMM_WORLD, status);
    std::_Exit(status);
  }

 private:
  void send_message(int to, std::string_view bytes, int tag) {
    MPI_Request request = MPI_REQUEST_NULL;
    MPI_Isend(bytes.data(), static_cast<int>(bytes.size()), MPI_BYTE, to, tag, MPI_COMM_WORLD,
              &request);
    // The other may be at work for long: a sleep in the place of MPI's busy waiting.
    RankPause pause;
    for (int done = 0;;) {
      MPI_Test(&request, &done, MPI_STATUS_IGNORE);
      if (done) break;
      pause.wait();
    }
    ++traffic_.messages;
    traffic_.bytes += bytes.size();
  }

  static std::string received(const MPI_Status& status, int tag) {
    int size = 0;
    MPI_Get_count(&status, MPI_BYTE, &size);
    std::string bytes(static_cast<std::size_t>(size), '\0');
    MPI_Recv(bytes.data(), size, MPI_BYTE, status.MPI_SOURCE, tag, MPI_COMM_WORLD,
             MPI_STATUS_IGNORE);
    return bytes;
  }

  int rank_ = 0, count_ = 1, neighbours_ = 1;
  RankTraffic traffic_;
};

bool is_started() {
  return std::any_of(kSigns.begin(), kSigns.end(),
                     [](const char* sign) { return std::getenv(sign) != nullptr; });
}

// MPI cannot start twice.
std::unique_ptr<MpiRanks> world;
bool is_over = false;

}  // namespace

Ranks* started_ranks() {
  if (!world && !is_over && is_started()) world = std::make_unique<MpiRanks>();
  return world && world->count() > 1 ? world.get() : nullptr;
}

void finish_ranks() {
  if (world) MPI_Finalize();
  world.reset();
  is_over = true;
}

}  // namespace lamella
