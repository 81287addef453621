#include "db/files/safe_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/evp.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <memory>

namespace tendril {
namespace {

namespace fs = std::filesystem;

Error IoError(const fs::path& file, const std::string& deed, int number) {
  const bool missing = number == ENOENT || number == ENOTDIR;
  return Error{missing ? ErrorKind::kNotFound : ErrorKind::kIo,
               file.string() + ": cannot " + deed + ": " + std::strerror(number)};
}

// A file descriptor, closed when left.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  int get() const { return fd_; }
  int Close() {  // 0 or errno: a network disk may report a full disk only here
    const int fd = fd_;
    fd_ = -1;
    return ::close(fd) == 0 ? 0 : errno;
  }

 private:
  int fd_;
};

// Removes the file unless it was kept.
class Leftover {
 public:
  explicit Leftover(fs::path file) : file_(std::move(file)) {}
  Leftover(const Leftover&) = delete;
  Leftover& operator=(const Leftover&) = delete;
  ~Leftover() {
    std::error_code ignored;
    if (!kept_) fs::remove(file_, ignored);
  }
  void Keep() { kept_ = true; }

 private:
  fs::path file_;
  bool kept_ = false;
};

int WriteAll(int fd, std::string_view text) {
  while (!text.empty()) {
    const ssize_t n = ::write(fd, text.data(), text.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno;
    text.remove_prefix(static_cast<size_t>(n));
  }
  return 0;
}

// Where a write to `file` ends up: a link is followed, so that it stays a link.
fs::path Target(const fs::path& file) {
  std::error_code error;
  const fs::path real = fs::is_symlink(file, error) ? fs::weakly_canonical(file, error) : file;
  return error ? file : real;
}

bool IsSpecial(const fs::path& file) {  // a device or pipe: nothing to rename over
  struct stat info {};
  return ::stat(file.c_str(), &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

fs::path NameBeside(const fs::path& target) {
  static std::atomic<unsigned> counter{0};
  return target.parent_path() / fmt::format(".{}.{}-{}.tmp{}", target.stem().string(), ::getpid(), counter++,
                                            target.extension().string());
}

// Flushes `beside` to the disk, gives it the target's mode and renames it over the target.
Status MoveOver(const fs::path& beside, const fs::path& target) {
  {
    Descriptor file(::open(beside.c_str(), O_RDWR | O_CLOEXEC));
    if (file.get() < 0) return IoError(target, "write", errno);
    struct stat before {};
    if (::stat(target.c_str(), &before) == 0 && ::fchmod(file.get(), before.st_mode & 07777) != 0) {
      return IoError(target, "keep its permissions", errno);
    }
    if (::fsync(file.get()) != 0) return IoError(target, "write", errno);
    if (const int error = file.Close(); error != 0) return IoError(target, "write", error);
  }
  if (::rename(beside.c_str(), target.c_str()) != 0) return IoError(target, "write", errno);
  const fs::path folder = target.has_parent_path() ? target.parent_path() : fs::path(".");
  const Descriptor directory(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (directory.get() >= 0) (void)::fsync(directory.get());  // some file systems have no such thing
  return Ok{};
}

Status WriteStraight(const fs::path& file, std::string_view text) {
  Descriptor special(::open(file.c_str(), O_WRONLY | O_CLOEXEC));
  if (special.get() < 0) return IoError(file, "write", errno);
  if (const int error = WriteAll(special.get(), text); error != 0) return IoError(file, "write", error);
  if (const int error = special.Close(); error != 0) return IoError(file, "write", error);
  return Ok{};
}

class Hasher {
 public:
  Hasher() : context_(EVP_MD_CTX_new(), EVP_MD_CTX_free) {
    EVP_DigestInit_ex(context_.get(), EVP_sha256(), nullptr);
  }
  void Add(const void* bytes, size_t count) { EVP_DigestUpdate(context_.get(), bytes, count); }
  std::string Hex() {
    std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
    unsigned length = 0;
    EVP_DigestFinal_ex(context_.get(), digest.data(), &length);
    std::string hex;
    for (unsigned i = 0; i < length; ++i) {
      hex += "0123456789abcdef"[digest[i] >> 4];
      hex += "0123456789abcdef"[digest[i] & 15];
    }
    return hex;
  }

 private:
  std::unique_ptr<EVP_MD_CTX, void (*)(EVP_MD_CTX*)> context_;
};

// Hands the file to `take` piece by piece.
template <class Take>
Status ReadPieces(const fs::path& file, Take take) {
  const Descriptor source(::open(file.c_str(), O_RDONLY | O_CLOEXEC));
  if (source.get() < 0) return IoError(file, "read", errno);
  std::string piece(1 << 16, '\0');
  while (true) {
    const ssize_t n = ::read(source.get(), piece.data(), piece.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return IoError(file, "read", errno);
    if (n == 0) return Ok{};
    take(piece.data(), static_cast<size_t>(n));
  }
}

}  // namespace

Result<std::string> ReadText(const fs::path& file) {
  std::string text;
  const Status read = ReadPieces(file, [&](const char* bytes, size_t count) { text.append(bytes, count); });
  if (!read.ok()) return read.error();
  return text;
}

Status WriteText(const fs::path& file, std::string_view text) {
  if (IsSpecial(file)) return WriteStraight(file, text);
  return WriteBeside(file, [&](const fs::path& beside) -> Status {
    Descriptor out(::open(beside.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
    if (out.get() < 0) return IoError(file, "write", errno);
    if (const int error = WriteAll(out.get(), text); error != 0) return IoError(file, "write", error);
    if (const int error = out.Close(); error != 0) return IoError(file, "write", error);
    return Ok{};
  });
}

Status WriteBeside(const fs::path& file, const std::function<Status(const fs::path& beside)>& write) {
  if (IsSpecial(file)) {
    return Error{ErrorKind::kBadInput, file.string() + ": is a device or pipe, expected a name for a file"};
  }
  const fs::path target = Target(file);
  const fs::path beside = NameBeside(target);
  Leftover leftover(beside);
  if (Status written = write(beside); !written.ok()) return written;
  if (Status moved = MoveOver(beside, target); !moved.ok()) return moved;
  leftover.Keep();
  return Ok{};
}

std::string Sha256(std::string_view bytes) {
  Hasher hasher;
  hasher.Add(bytes.data(), bytes.size());
  return hasher.Hex();
}

Result<std::string> Sha256OfFile(const fs::path& file) {
  Hasher hasher;
  const Status read = ReadPieces(file, [&](const char* bytes, size_t count) { hasher.Add(bytes, count); });
  if (!read.ok()) return read.error();
  return hasher.Hex();
}

}  // namespace tendril
