#include "db/files/hdf5_file.h"

#include <fmt/format.h>

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

}  // namespace

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
  if (count > 0 && H5Dget_storage_size(data.get()) == 0) return Wrong("was never written");
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

bool WriteArray(hid_t parent, const std::string& name, const Array& array, hid_t file_type) {
  const Handle space(H5Screate_simple(static_cast<int>(array.shape.size()), array.shape.data(), nullptr),
                     H5Sclose);
  const Handle data(
      H5Dcreate2(parent, name.c_str(), file_type, space.get(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose);
  if (!space.ok() || !data.ok()) return false;
  if (!array.values.empty() &&
      H5Dwrite(data.get(), H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) < 0) {
    return false;
  }
  return WriteText(data.get(), "units", array.units);
}

}  // namespace tendril::hdf5
