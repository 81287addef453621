#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "db/files/scene_tables.h"
#include "db/files/toml_write.h"

namespace tendril {
namespace {

using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

bool IsLong(const std::string& kind) { return kind == "cylinder" || kind == "capsule"; }

// The sizes of a cylinder, capsule, sphere or box.
Primitive ReadSizes(TomlTable& table, const std::string& kind) {
  Primitive primitive;
  if (kind == "box") {
    primitive.kind = PrimitiveKind::kBox;
    Vector3d size = Vector3d::Ones();
    table.Required().Vector("size", size, Above(0, "m"));
    primitive.half = 0.5 * size;
    return primitive;
  }
  primitive.radius = 1;
  table.Required().Number("radius", primitive.radius, Above(0, "m"));
  if (!IsLong(kind)) return primitive;
  double length = 1;
  table.Required().Number("length", length, Above(0, "m"));
  const bool flat = kind == "cylinder";
  primitive.kind = flat ? PrimitiveKind::kCylinder : PrimitiveKind::kCapsule;
  primitive.half.z() = std::max(0.0, 0.5 * length - (flat ? 0.0 : primitive.radius));
  return primitive;
}

// About the outer frame's x, then its y, then its z.
Matrix3d ReadTurns(TomlTable& table) {
  Vector3d degrees = Vector3d::Zero();
  table.Vector("rotation_deg", degrees, Finite("deg"));
  Matrix3d turned = Matrix3d::Identity();
  for (const Eigen::Index k : {0, 1, 2}) {
    turned = Eigen::AngleAxisd(RadiansOfDegrees(degrees[k]), Vector3d::Unit(k)) * turned;
  }
  return turned;
}

struct Placed {
  Isometry3d pose = Isometry3d::Identity();
  Vector3d along = Vector3d::UnitX();  // unit; of what is long
};

// `position`, and `axis` (of what is long) or `rotation_deg`.
Placed ReadPlace(TomlTable& table, const std::string& kind) {
  Placed placed;
  Vector3d position = Vector3d::Zero(), axis = Vector3d::UnitX();
  table.Vector("position", position);
  placed.pose.translation() = position;
  const bool turned = table.Has("rotation_deg");
  if (turned || kind == "box" || kind == "union") {
    placed.pose.linear() = ReadTurns(table);
    placed.along = placed.pose.linear().col(2);
    if (turned && IsLong(kind) && table.Has("axis")) {
      table.Reject("axis", "an axis or a rotation_deg, not both");
    }
  } else if (IsLong(kind)) {
    table.Vector("axis", axis);
    if (!(axis.norm() > 0)) {
      table.Reject("axis", "a direction, not all zeros");
      axis = Vector3d::UnitX();
    }
    placed.along = axis.normalized();
    placed.pose.linear() = Eigen::Quaterniond::FromTwoVectors(Vector3d::UnitZ(), axis).toRotationMatrix();
  }
  return placed;
}

// In the frame that the file gives it in.
Shape ReadShape(TomlTable& table, const std::string& kind) {
  if (kind != "union") return {ReadSizes(table, kind)};
  Shape shape;
  std::vector<TomlTable> parts = table.Tables("part");
  if (parts.empty()) table.Reject("part", "one [[object.part]] or more, for a union is made of them");
  for (TomlTable& part : parts) {
    std::string part_kind = "sphere";
    if (!part.Required().Choice("kind", part_kind, {"cylinder", "capsule", "sphere", "box"})) {
      part.Skip();
      continue;
    }
    Primitive primitive = ReadSizes(part, part_kind);
    primitive.object_from_primitive = ReadPlace(part, part_kind).pose;
    shape.push_back(primitive);
  }
  return shape;
}

void ReadInertia(TomlTable& table, SceneObject& object) {
  table.Vector("inertia", object.inertia, Above(0, "kg m^2"));
  const Vector3d& i = object.inertia;
  if (2 * i.maxCoeff() > i.sum() * (1 + 1e-9)) {
    table.Reject("inertia", "three numbers of which none is above the others' sum");
  }
}

// Puts the shape into its own frame. A stated inertia is about the file's axes, which are then the object's.
//   returns  given_from_object
Isometry3d Balance(TomlTable& table, SceneObject& object, const Shape& given) {
  Isometry3d given_from_object = Isometry3d::Identity();
  if (given.empty()) return given_from_object;  // said
  if (table.Has("inertia")) {
    ReadInertia(table, object);
    const Result<MassProperties> properties = MassOf(given);
    if (!properties.ok()) {
      table.Reject("kind", properties.error().message);
      return given_from_object;
    }
    given_from_object.translation() = properties.value().centre;
    object.shape = given;
    for (Primitive& part : object.shape) {
      part.object_from_primitive = given_from_object.inverse() * part.object_from_primitive;
    }
    return given_from_object;
  }
  Result<BalancedShape> balanced = Balanced(given);
  if (!balanced.ok()) {
    table.Reject("kind", balanced.error().message);
    return given_from_object;
  }
  object.shape = std::move(balanced.value().shape);
  object.inertia = object.mass * balanced.value().inertia;
  return balanced.value().given_from_object;
}

// Where a line up from the centre of mass leaves the shape, in the object; where it meets nothing above the
// centre, on it at the height of the shape's top, as a sling would hold it.
Vector3d TopOf(const Shape& shape, const Vector3d& up_in_object) {
  constexpr double kNear = 1e-9;
  double height = ReachOf(shape);
  for (int step = 0; step < 1000 && height > 0; ++step) {
    double distance = HUGE_VAL;
    for (const Primitive& part : shape) {
      distance = std::min(distance, DistanceTo(part, height * up_in_object).distance);
    }
    if (distance < kNear) return height * up_in_object;
    height -= distance;
  }
  height = 0;
  for (const SurfaceSphere& sphere : SurfaceSpheres(shape)) {
    height = std::max(height, sphere.centre.dot(up_in_object) + sphere.radius);
  }
  return height * up_in_object;
}

void ReadString(TomlTable& table, const Isometry3d& given_from_object, const Vector3d& gravity,
                SceneObject& object) {
  const Vector3d up = gravity.norm() > 0 ? Vector3d(-gravity.normalized()) : Vector3d(Vector3d::UnitZ());
  BodyString& string = object.string;
  Vector3d to_in_given;
  string.to_in_body = table.Vector("string_to", to_in_given, Finite("m"))
                          ? Vector3d(given_from_object.inverse() * to_in_given)
                          : TopOf(object.shape, object.pose.linear().transpose() * up);
  const Vector3d to = object.pose * string.to_in_body;
  const bool has_length = table.Number("string_length", string.length, Above(0, "m"));
  if (!table.Vector("string_from", string.from, Finite("m"))) {
    if (!has_length) table.Reject("string_length", "a number > 0 m, or a string_from");
    string.from = to + string.length * up;
    return;
  }
  const double apart = (string.from - to).norm();
  if (!has_length) string.length = apart;
  if (apart > string.length * (1 + 1e-9)) {
    table.Reject("string_length", fmt::format("{:.6g} m or more, which its ends are apart", apart));
  }
}

SceneObject ReadObject(TomlTable& table, std::size_t number, const Vector3d& gravity) {
  SceneObject object;
  object.name = fmt::format("object{}", number);
  ReadName(table, object.name);
  if (!table.Required().Choice("kind", object.kind, {"cylinder", "capsule", "sphere", "box", "union"})) {
    table.Skip();  // what else it needs hangs on the kind
    return object;
  }
  const Shape given = ReadShape(table, object.kind);
  const Placed placed = ReadPlace(table, object.kind);
  const Vector3d position = placed.pose.translation();
  object.body.start = object.body.end = position;
  if (object.kind != "box" && object.kind != "union") {
    // The body's ends are round: a cylinder counts as a capsule of its length, ends included.
    object.body.radius = given[0].radius;
    const double flat_ends = object.kind == "cylinder" ? object.body.radius : 0;
    const double half = std::max(0.0, given[0].half.z() - flat_ends);
    object.body.start = position - half * placed.along;
    object.body.end = position + half * placed.along;
  }

  std::string motion = "fixed";
  table.Choice("motion", motion, {"fixed", "free", "hanging"});
  object.motion = motion == "free"      ? ObjectMotion::kFree
                  : motion == "hanging" ? ObjectMotion::kHanging
                                        : ObjectMotion::kFixed;
  const bool moves = object.motion != ObjectMotion::kFixed;
  if (moves) table.Required();
  table.Number("mass", object.mass, Above(0, "kg"));
  double friction = 0;
  if (table.Number("friction", friction, AtLeast(0))) object.friction = friction;
  table.Number("drag_scale", object.drag_scale, AtLeast(0));

  const Isometry3d given_from_object = Balance(table, object, given);
  object.pose = placed.pose * given_from_object;
  table.Vector("velocity", object.velocity, Finite("m/s"));
  table.Vector("spin", object.spin, Finite("rad/s"));
  for (const char* key : {"velocity", "spin"}) {
    if (!moves && table.Has(key)) table.Reject(key, "motion = free or hanging beside it");
  }
  if (object.motion == ObjectMotion::kHanging) {
    ReadString(table, given_from_object, gravity, object);
  } else {
    for (const char* key : {"string_length", "string_from", "string_to"}) {
      if (table.Has(key)) table.Reject(key, "motion = hanging beside it");
    }
  }
  return object;
}

SceneObject ReadTable(TomlTable& table) {
  SceneObject object;
  object.kind = object.name = "table";
  double height = 0, friction = 0;
  table.Required().Number("height", height, Finite("m"));
  if (table.Number("friction", friction, AtLeast(0))) object.friction = friction;
  object.shape = {Primitive{.kind = PrimitiveKind::kHalfSpace}};
  object.pose.translation() = Vector3d(0, 0, height);
  object.body.start = object.body.end = object.pose.translation();
  return object;
}

}  // namespace

std::vector<SceneObject> ReadObjects(TomlDocument& document, const Vector3d& gravity) {
  std::vector<SceneObject> objects;
  std::set<std::string> names = {"table"};
  for (TomlTable& table : document.Tables("object")) {
    objects.push_back(ReadObject(table, objects.size(), gravity));
    if (!names.insert(objects.back().name).second) table.Reject("name", "a name of its own for each object");
  }
  TomlTable table = document.Table("table");
  if (table.exists()) objects.push_back(ReadTable(table));
  return objects;
}

}  // namespace tendril
