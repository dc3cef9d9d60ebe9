#include "compare/files/output_folder.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <string>
#include <system_error>

#include "compare/files/open_file.h"

namespace lamella {
namespace {

namespace fs = std::filesystem;

using Content = std::function<void(const AddBytes& add)>;

void write_content(OpenFile& file, const fs::path& path, const Content& content) {
  content([&](std::string_view bytes) {
    if (const auto error = file.write(bytes)) fail_at("write", path, error);
  });
}

void write_in_place(const fs::path& path, const Content& content) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) fail_at("write", path, last_system_error());
  OpenFile file(descriptor, {});
  write_content(file, path, content);
  if (const auto error = file.close()) fail_at("write", path, error);
}

void write_and_rename(const fs::path& path, const Content& content) {
  TemporaryFile temporary = temporary_beside(path);
  write_content(temporary.file, path, content);
  take_name(temporary.file, temporary.name, path);
}

}  // namespace

void make_output_folder(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder, error);
  const fs::file_status status = fs::status(folder);
  if (fs::exists(status) && !fs::is_directory(status))
    throw OutputError(
        fmt::format("cannot use {} as a folder: it is a file or device", folder.string()));
  if (error) fail_at("make folder", folder, error);
  if (::access(folder.c_str(), W_OK | X_OK) != 0)
    fail_at("write to folder", folder, last_system_error());
}

void check_output_file(const fs::path& path) {
  const fs::file_status status = fs::status(path);
  if (fs::is_directory(status))
    fail_at("write", path, std::make_error_code(std::errc::is_a_directory));
  const fs::path parent = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (fs::exists(status) && ::access(path.c_str(), W_OK) != 0)
    fail_at("write", path, last_system_error());
  if (fs::exists(status) && !fs::is_regular_file(status)) return;
  if (fs::exists(parent) && !fs::is_directory(parent))
    fail_at("write", path, std::make_error_code(std::errc::not_a_directory));
  if (::access(parent.c_str(), W_OK | X_OK) != 0) fail_at("write", path, last_system_error());
}

fs::path written_path(const fs::path& path) {
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (fs::is_directory(status))
    fail_at("write", path, std::make_error_code(std::errc::is_a_directory));
  if (!fs::exists(status)) return path;
  // A rename would pass over a file's own write protection.
  if (::access(path.c_str(), W_OK) != 0) fail_at("write", path, last_system_error());
  if (!fs::is_regular_file(status)) return {};
  const fs::path target = fs::canonical(path, error);
  return error ? path : target;
}

void write_file(const fs::path& path, std::string_view bytes) {
  write_file(path, [bytes](const AddBytes& add) { add(bytes); });
}

void write_file(const fs::path& path, const Content& content) {
  const fs::path target = written_path(path);
  if (target.empty()) return write_in_place(path, content);
  write_and_rename(target, content);
}

}  // namespace lamella
