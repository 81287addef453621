#include "db/files/hdf5_file.h"

#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <new>

namespace tendril::hdf5 {
namespace {

std::mutex& Lock() {
  static std::mutex lock;
  return lock;
}

Error Wrong(const std::string& what) { return Error{ErrorKind::kBadInput, what}; }

std::string ReadTextAttribute(hid_t object, const std::string& name) {
  if (H5Aexists(object, name.c_str()) <= 0) return "";
  const Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose);
  const Handle type(H5Aget_type(attribute.get()), H5Tclose);
  if (!type.ok() || H5Tget_class(type.get()) != H5T_STRING) return "";
  if (H5Tis_variable_str(type.get()) > 0) {
    char* text = nullptr;
    const Handle memory(H5Tcopy(H5T_C_S1), H5Tclose);
    H5Tset_size(memory.get(), H5T_VARIABLE);
    H5Tset_cset(memory.get(), H5Tget_cset(type.get()));
    if (H5Aread(attribute.get(), memory.get(), &text) < 0 || text == nullptr) return "";
    std::string out(text);
    H5free_memory(text);
    return out;
  }
  const Handle space(H5Aget_space(attribute.get()), H5Sclose);
  if (H5Sget_simple_extent_npoints(space.get()) != 1) return "";
  std::string text(H5Tget_size(type.get()), '\0');
  if (H5Aread(attribute.get(), type.get(), text.data()) < 0) return "";
  return text.substr(0, text.find('\0'));
}

herr_t AddGroupName(hid_t parent, const char* name, const H5L_info_t*, void* names) {
  H5O_info_t info;
  if (H5Oget_info_by_name2(parent, name, &info, H5O_INFO_BASIC, H5P_DEFAULT) >= 0 &&
      info.type == H5O_TYPE_GROUP) {
    static_cast<std::vector<std::string>*>(names)->emplace_back(name);
  }
  return 0;
}

// The buffer of a file in memory, of which HDF5 gives no whole copy otherwise: H5Fget_file_image leaves a
// checksum in it that is wrong.
struct Image {
  size_t size = 0;
  std::string bytes;  // once the file is closed
};

void* Allocate(size_t size, H5FD_file_image_op_t, void* image) {
  static_cast<Image*>(image)->size = size;
  return std::malloc(size);
}
void* Copy(void* to, const void* from, size_t size, H5FD_file_image_op_t, void*) {
  return std::memcpy(to, from, size);
}
void* Grow(void* buffer, size_t size, H5FD_file_image_op_t, void* image) {
  static_cast<Image*>(image)->size = size;
  return std::realloc(buffer, size);
}
herr_t Release(void* buffer, H5FD_file_image_op_t deed, void* data) {
  herr_t done = 0;
  if (deed == H5FD_FILE_IMAGE_OP_FILE_CLOSE && buffer != nullptr) {
    auto* image = static_cast<Image*>(data);
    try {
      image->bytes.assign(static_cast<const char*>(buffer), image->size);
    } catch (const std::bad_alloc&) {  // HDF5's C code must not see it
      done = -1;
    }
  }
  std::free(buffer);
  return done;
}
void* SameData(void* data) { return data; }
herr_t KeepData(void*) { return 0; }

}  // namespace

Result<std::string> MakeFile(const std::function<bool(hid_t file)>& fill) {
  const Session session;
  Image image;
  bool good = false;
  {
    const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    constexpr size_t kGrowth_bytes = 4096;  // what the file may be longer than it need be
    H5Pset_fapl_core(access.get(), kGrowth_bytes, /*backing_store=*/false);
    H5Pset_libver_bounds(access.get(), H5F_LIBVER_V18, H5F_LIBVER_V18);
    H5FD_file_image_callbacks_t callbacks{Allocate, Copy, Grow, Release, SameData, KeepData, &image};
    H5Pset_file_image_callbacks(access.get(), &callbacks);
    const Handle made(H5Pcreate(H5P_FILE_CREATE), H5Pclose);
    H5Pset_obj_track_times(made.get(), false);
    const Handle file(H5Fcreate("in memory", H5F_ACC_TRUNC, made.get(), access.get()), H5Fclose);
    good = file.ok() && fill(file.get());
  }
  if (!good || image.bytes.empty()) {
    return Error{ErrorKind::kIo, "HDF5 could not make this file (out of memory?)"};
  }
  // The buffer grows in steps; the superblock (version 2) says where the file ends.
  constexpr size_t kEndAt = 28;
  std::uint64_t end = 0;
  if (image.bytes.size() >= kEndAt + sizeof end && image.bytes[8] == 2) {
    std::memcpy(&end, image.bytes.data() + kEndAt, sizeof end);
    if (end >= kEndAt && end < image.bytes.size()) image.bytes.resize(end);
  }
  return std::move(image.bytes);
}

Session::Session() {
  Lock().lock();
  H5Eget_auto2(H5E_DEFAULT, &print_, &print_data_);
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

Session::~Session() {
  H5Eset_auto2(H5E_DEFAULT, print_, print_data_);
  Lock().unlock();
}

bool Has(hid_t parent, const std::string& name) { return H5Lexists(parent, name.c_str(), H5P_DEFAULT) > 0; }

std::vector<std::string> GroupNames(hid_t parent) {
  std::vector<std::string> names;
  if (H5Literate(parent, H5_INDEX_CRT_ORDER, H5_ITER_INC, nullptr, AddGroupName, &names) < 0) {
    names.clear();
    H5Literate(parent, H5_INDEX_NAME, H5_ITER_INC, nullptr, AddGroupName, &names);
  }
  return names;
}

Result<Handle> OpenToRead(const std::filesystem::path& path) {
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) {
    return Error{ErrorKind::kNotFound, path.string() + ": no such file"};
  }
  if (H5Fis_hdf5(path.c_str()) <= 0) {
    return Error{ErrorKind::kBadInput, path.string() + ": is not an HDF5 file (empty or truncated?)"};
  }
  Handle file(H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT), H5Fclose);
  if (!file.ok())
    return Error{ErrorKind::kBadInput, path.string() + ": cannot be opened as HDF5 (truncated?)"};
  return file;
}

Result<Array> ReadArray(hid_t parent, const std::string& name) {
  const Handle data(H5Dopen2(parent, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!data.ok()) return Wrong("cannot be opened as a dataset (truncated?)");
  const Handle type(H5Dget_type(data.get()), H5Tclose);
  const H5T_class_t kind = H5Tget_class(type.get());
  if (kind != H5T_FLOAT && kind != H5T_INTEGER) return Wrong("holds no numbers, expected float64");
  const Handle space(H5Dget_space(data.get()), H5Sclose);
  const int rank = H5Sget_simple_extent_ndims(space.get());
  if (rank < 1) return Wrong("is a single value, expected an array");
  Array array;
  array.shape.resize(static_cast<size_t>(rank));
  H5Sget_simple_extent_dims(space.get(), array.shape.data(), nullptr);
  const hssize_t count = H5Sget_simple_extent_npoints(space.get());
  const hsize_t stored = H5Dget_storage_size(data.get());
  if (count > 0 && stored == 0) return Wrong("was never written");
  const Handle made(H5Dget_create_plist(data.get()), H5Pclose);
  const bool contiguous = H5Pget_layout(made.get()) == H5D_CONTIGUOUS;
  hsize_t file_size = 0;
  H5Fget_filesize(Handle(H5Iget_file_id(data.get()), H5Fclose).get(), &file_size);
  // Before room is made for what a damaged header claims.
  if (stored > file_size || (contiguous && static_cast<hsize_t>(count) > file_size)) {
    return Wrong(fmt::format("claims {} values, more than the file holds (truncated?)", count));
  }
  try {
    array.values.resize(static_cast<size_t>(count));
  } catch (const std::exception&) {
    return Wrong(fmt::format("claims {} values, more than fits into memory", count));
  }
  if (count > 0 &&
      H5Dread(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) < 0) {
    return Wrong("cannot be read (truncated?)");
  }
  array.units = ReadTextAttribute(data.get(), "units");
  return array;
}

bool WriteText(hid_t object, const std::string& name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type.get(), text.empty() ? 1 : text.size());
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  H5Tset_strpad(type.get(), H5T_STR_NULLPAD);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(object, name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  return attribute.ok() && H5Awrite(attribute.get(), type.get(), text.empty() ? "\0" : text.data()) >= 0;
}

Handle MakeGroup(hid_t parent, const std::string& name) {
  const Handle made(H5Pcreate(H5P_GROUP_CREATE), H5Pclose);
  H5Pset_link_creation_order(made.get(), H5P_CRT_ORDER_TRACKED | H5P_CRT_ORDER_INDEXED);
  H5Pset_obj_track_times(made.get(), false);
  return {H5Gcreate2(parent, name.c_str(), H5P_DEFAULT, made.get(), H5P_DEFAULT), H5Gclose};
}

bool WriteArray(hid_t parent, const std::string& name, const Array& array, hid_t file_type) {
  const Handle space(H5Screate_simple(static_cast<int>(array.shape.size()), array.shape.data(), nullptr),
                     H5Sclose);
  const Handle made(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_obj_track_times(made.get(), false);  // the same content is the same bytes
  const Handle data(
      H5Dcreate2(parent, name.c_str(), file_type, space.get(), H5P_DEFAULT, made.get(), H5P_DEFAULT),
      H5Dclose);
  if (!space.ok() || !data.ok()) return false;
  if (!array.values.empty() &&
      H5Dwrite(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) < 0) {
    return false;
  }
  return WriteText(data.get(), "units", array.units);
}

}  // namespace tendril::hdf5
