#pragma once
// The little of HDF5 that we use, with handles that close themselves and errors as results. HDF5 itself is
// not safe to call from two threads at once: every function here takes its one lock.

#include <hdf5.h>

#include <filesystem>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "model/result.h"

namespace tendril::hdf5 {

// Holds HDF5's lock, and keeps it from printing its error stack, as long as it lives.
class Session {
 public:
  Session();
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  ~Session();

 private:
  H5E_auto2_t print_ = nullptr;
  void* print_data_ = nullptr;
};

// An identifier that is closed when left; negative: none.
class Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Handle() = default;
  Handle(hid_t id, Close close) : id_(id), close_(close) {}
  Handle(Handle&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Handle& operator=(Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  bool ok() const { return id_ >= 0; }
  hid_t get() const { return id_; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

// A file that is there and is HDF5, to be read; within a Session.
//   errors  kNotFound no such file; kBadInput not HDF5, or truncated
Result<Handle> OpenToRead(const std::filesystem::path& path);

// What a dataset holds, row-major.
struct Array {
  std::vector<hsize_t> shape;
  std::vector<double> values;
  std::string units;  // its attribute; empty: none
};

//   errors  kBadInput not numbers, no data, truncated; the message has no place in front
Result<Array> ReadArray(hid_t parent, const std::string& name);
bool Has(hid_t parent, const std::string& name);
std::vector<std::string> GroupNames(hid_t parent);  // in the order of making, else by name

// A new group, whose members are listed in the order of making; without a time of making, so that the same
// content is the same bytes.
Handle MakeGroup(hid_t parent, const std::string& name);

// The bytes of a new file that `fill` writes. Made in memory, so that the caller writes them safely:
// HDF5 1.10 cannot close a file that the disk had no room for, and crashes when the program ends. In the
// format of HDF5 1.8 and later, whose structures carry checksums: a damaged file is an error rather than a
// crash.
Result<std::string> MakeFile(const std::function<bool(hid_t file)>& fill);

// Writes of an open, new file: false once HDF5 says that one failed.
bool WriteArray(hid_t parent, const std::string& name, const Array& array, hid_t file_type);
bool WriteText(hid_t object, const std::string& name, const std::string& text);

}  // namespace tendril::hdf5
