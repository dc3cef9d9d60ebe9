#include "compare/files/streamed_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <utility>

#include "compare/files/output_folder.h"

namespace lamella {
namespace {

OpenFile opened_in_place(const std::filesystem::path& path) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) fail_at("write", path, last_system_error());
  return {descriptor, {}};
}

OpenFile nameless_beside(const std::filesystem::path& path) {
  TemporaryFile temporary = temporary_beside(path);
  if (::unlink(temporary.name.c_str()) != 0) fail_at("write", path, last_system_error());
  temporary.file.keep();
  return std::move(temporary.file);
}

}  // namespace

void NamelessFile::append(std::string_view bytes) {
  constexpr std::size_t kBlock = std::size_t{4} << 20;
  size_ += bytes.size();
  if (!file_ && size_ <= kMostKept) {
    if (kept_.empty() || kept_.back().size() + bytes.size() > kBlock) {
      kept_.emplace_back();
      kept_.back().reserve(std::max(kBlock, bytes.size()));
    }
    kept_.back().append(bytes);
    return;
  }
  if (!file_) move_to_disk();
  if (const auto error = file_->write(bytes)) fail_at("write", path_, error);
}

void NamelessFile::move_to_disk() {
  file_.emplace(nameless_beside(path_));
  for (const std::string& block : kept_)
    if (const auto error = file_->write(block)) fail_at("write", path_, error);
  std::vector<std::string>().swap(kept_);
}

void NamelessFile::each_piece(const std::function<void(std::string_view)>& take) const {
  for (const std::string& block : kept_) take(block);
  if (!file_) return;
  std::string bytes(std::size_t{1} << 20, '\0');
  for (std::uint64_t at = 0; at < size_;) {
    const ssize_t count =
        ::pread(file_->descriptor(), bytes.data(), bytes.size(), static_cast<off_t>(at));
    if (count < 0 && errno == EINTR) continue;
    if (count == 0) errno = EIO;
    if (count <= 0) fail();
    take({bytes.data(), static_cast<std::size_t>(count)});
    at += static_cast<std::uint64_t>(count);
  }
}

void NamelessFile::close() {
  std::vector<std::string>().swap(kept_);
  if (!file_) return;
  if (const auto error = file_->close()) fail_at("write", path_, error);
  file_.reset();
}

void NamelessFile::fail() const {
  fail_at("read back what was written for", path_, last_system_error());
}

StreamedFile::StreamedFile(std::filesystem::path path)
    : path_(std::move(path)),
      target_(written_path(path_)),
      direct_(target_.empty() ? opened_in_place(path_) : OpenFile()) {
  if (!target_.empty()) temporary_.emplace(temporary_beside(target_));
}

void StreamedFile::write(std::string_view bytes) {
  if (const auto error = file().write(bytes)) fail_at("write", path_, error);
  size_ += bytes.size();
}

void StreamedFile::append(const NamelessFile& from) {
  from.each_piece([this](std::string_view bytes) { write(bytes); });
}

std::uint64_t StreamedFile::finish() {
  if (temporary_)
    take_name(temporary_->file, temporary_->name, target_);
  else if (const auto error = direct_.close())
    fail_at("write", path_, error);
  return size_;
}

}  // namespace lamella
