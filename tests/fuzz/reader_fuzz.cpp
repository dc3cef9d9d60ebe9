// libFuzzer on the reader that LAMELLA_READER names. With the one argument --seeds FOLDER it writes
// whole inputs there instead.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "tests/fuzz/input_readers.h"

namespace {

const lamella::InputReader& reader() {
  const auto& list = lamella::input_readers();
  const auto found = std::find_if(list.begin(), list.end(),
                                  [](const auto& r) { return r.name == LAMELLA_READER; });
  if (found == list.end()) std::abort();
  return *found;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc != 3 || std::strcmp((*argv)[1], "--seeds") != 0) return 0;
  const std::filesystem::path folder = (*argv)[2];
  std::filesystem::create_directories(folder);
  int number = 0;
  for (const std::string& seed : reader().seeds())
    std::ofstream(folder / ("seed" + std::to_string(number++)), std::ios::binary) << seed;
  std::exit(0);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  (void)reader().read({reinterpret_cast<const char*>(data), size});
  return 0;
}
