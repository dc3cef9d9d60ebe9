// Feeds arbitrary text to the reader of stack files: a stack that can be written and read back, or
// a StackFileError; anything else is a failure. With the one argument --seeds FOLDER it writes the
// built-in stacks there instead.

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>

#include "phase/stack/builtin_stacks.h"
#include "phase/stack/stack_file.h"

extern "C" int LLVMFuzzerInitialize(int* argc, char*** argv) {
  if (*argc != 3 || std::strcmp((*argv)[1], "--seeds") != 0) return 0;
  const std::filesystem::path folder = (*argv)[2];
  std::filesystem::create_directories(folder);
  for (const lamella::BuiltinStack& stack : lamella::builtin_stacks())
    std::ofstream(folder / (stack.name + ".toml")) << stack.toml;
  std::exit(0);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  std::string written;
  try {
    written = lamella::to_toml(lamella::parse_stack(text, "fuzz.toml", "fuzz"));
  } catch (const lamella::StackFileError&) {
    return 0;
  }
  // What was accepted must read back the same; a StackFileError here ends the run.
  if (lamella::to_toml(lamella::parse_stack(written, "again.toml", "fuzz")) != written) {
    std::cerr << "reads back differently:\n" << written;
    std::abort();
  }
  return 0;
}
