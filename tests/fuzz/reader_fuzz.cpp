// libFuzzer on the reader that the environment variable LAMELLA_READER names. With the one argument
// --seeds FOLDER it writes whole inputs there instead, with the one argument --list the readers'
// names to standard output.

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "tests/fuzz/input_readers.h"

namespace {

const lamella::InputReader& named_reader() {
  const char* name = std::getenv("LAMELLA_READER");
  const auto& list = lamella::input_readers();
  const auto found = std::find_if(list.begin(), list.end(),
                                  [&](const auto& r) { return name && r.name == name; });
  if (found != list.end()) return *found;
  std::cerr << "LAMELLA_READER: found \"" << (name ? name : "") << "\"; --list prints the names\n";
  std::exit(2);
}

const lamella::InputReader& reader() {
  static const lamella::InputReader& named = named_reader();
  return named;
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc == 2 && std::strcmp((*argv)[1], "--list") == 0) {
    for (const lamella::InputReader& r : lamella::input_readers()) std::cout << r.name << '\n';
    std::exit(0);
  }
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
