// db/files/curve_files.h, objects over time: what is read is what was written; signs that do not jump; every
// slip named; files without objects and damaged ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>

#include <chrono>
#include <cmath>
#include <functional>
#include <random>
#include <thread>

#include "db/files/curve_files.h"
#include "tests/support/program.h"

namespace tendril {
namespace {

using testing::HasSubstr;
using testing_support::TemporaryFolder;

CurveSeries Rod(int frames) {
  CurveSeries rod;
  rod.name = "rod";
  rod.time = Eigen::VectorXd::LinSpaced(frames, 0, 0.1 * (frames - 1));
  rod.curves.resize(static_cast<std::size_t>(frames));
  for (FramedCurve& curve : rod.curves) curve.points = Eigen::Matrix3Xd::Random(3, 4);
  return rod;
}

ObjectSeries Tumbling(const std::string& name, int frames, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  ObjectSeries object{name, {}, {}};
  for (int f = 0; f < frames; ++f) {
    Eigen::Isometry3d pose(Eigen::AngleAxisd(2.1 * f, Eigen::Vector3d(1, 2, -2) / 3));
    pose.translation() = Eigen::Vector3d(normal(random), 1e-6 * normal(random), 1e6 * normal(random));
    object.poses.push_back(pose);
    object.forces.emplace_back(normal(random), 0, -1e-300);
  }
  return object;
}

// What a dataset of the file holds, read without the code under test.
std::vector<double> Numbers(const std::string& file, const std::string& dataset) {
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  const hid_t set = H5Dopen2(f, dataset.c_str(), H5P_DEFAULT);
  const hid_t space = H5Dget_space(set);
  std::vector<double> numbers(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)));
  H5Dread(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data());
  H5Sclose(space);
  H5Dclose(set);
  H5Fclose(f);
  return numbers;
}

// Changes an open file.
void Bend(const std::string& file, const std::function<void(hid_t)>& change) {
  const hid_t f = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
  change(f);
  H5Fclose(f);
}

void Overwrite(hid_t file, const char* dataset, std::vector<double> values) {
  const hid_t set = H5Dopen2(file, dataset, H5P_DEFAULT);
  H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
  H5Dclose(set);
}

class ObjectFiles : public testing::Test {
 protected:
  TemporaryFolder folder_;
  std::string file_ = folder_ / "c.h5";
};

TEST_F(ObjectFiles, WhatIsReadIsWhatWasWrittenInItsOrder) {
  const std::vector<CurveSeries> rods = {Rod(7)};
  const std::vector<ObjectSeries> objects = {Tumbling("the ball", 7, 1), Tumbling("a box", 7, 2)};
  ASSERT_TRUE(WriteCurves(file_, rods, "test", objects).ok());
  const auto read = ReadObjectsOverTime(file_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().time, rods[0].time);
  ASSERT_EQ(read.value().objects.size(), 2U);
  for (std::size_t o = 0; o < 2; ++o) {
    const ObjectSeries& got = read.value().objects[o];
    EXPECT_EQ(got.name, objects[o].name);
    for (std::size_t f = 0; f < 7; ++f) {
      EXPECT_EQ(got.poses[f].translation(), objects[o].poses[f].translation());
      EXPECT_EQ(got.forces[f], objects[o].forces[f]);
      EXPECT_LT((got.poses[f].linear() - objects[o].poses[f].linear()).cwiseAbs().maxCoeff(), 4e-15);
    }
  }
  const auto curves = ReadCurves(file_);
  ASSERT_TRUE(curves.ok());
  EXPECT_EQ(curves.value()[0].curves[3].points, rods[0].curves[3].points);
}

TEST_F(ObjectFiles, OrientationsAreXyzwFromObjectToLabAndKeepTheirSide) {
  // A quarter turn about z takes x to y: (0, 0, sin 45, cos 45).
  ObjectSeries object{"o", {}, {}};
  for (int f = 0; f < 40; ++f) {
    object.poses.emplace_back(Eigen::AngleAxisd(f * M_PI / 8, Eigen::Vector3d::UnitZ()));
    object.forces.emplace_back(Eigen::Vector3d::Zero());
  }
  ASSERT_TRUE(WriteCurves(file_, std::vector{Rod(40)}, "test", std::vector{object}).ok());
  const std::vector<double> q = Numbers(file_, "/object/o/orientation");
  ASSERT_EQ(q.size(), 160U);
  EXPECT_NEAR(q[4 * 4 + 2], std::sqrt(0.5), 1e-15);
  EXPECT_NEAR(q[4 * 4 + 3], std::sqrt(0.5), 1e-15);
  for (std::size_t f = 0; f < 40; ++f) {
    EXPECT_NEAR(q[4 * f + 3], std::cos(static_cast<double>(f) * M_PI / 16), 1e-14) << "no sign jumps";
  }
}

TEST_F(ObjectFiles, AFileWithoutObjectsHasNoneAndACsvGoesWithout) {
  ASSERT_TRUE(WriteCurves(file_, std::vector{Rod(2)}, "test").ok());
  const auto none = ReadObjectsOverTime(file_);
  ASSERT_TRUE(none.ok());
  EXPECT_TRUE(none.value().objects.empty());
  const std::vector<CurveSeries> rods = {Rod(2)};
  ASSERT_TRUE(WriteCurves(folder_ / "with.csv", rods, "test", std::vector{Tumbling("o", 2, 1)}).ok());
  ASSERT_TRUE(WriteCurves(folder_ / "without.csv", rods, "test").ok());
  EXPECT_EQ(testing_support::ReadText(folder_ / "with.csv"),
            testing_support::ReadText(folder_ / "without.csv"));
  EXPECT_EQ(ReadObjectsOverTime(folder_ / "no.h5").error().kind, ErrorKind::kNotFound);
  EXPECT_THAT(ReadObjectsOverTime(folder_ / "with.csv").error().message, HasSubstr("is not an HDF5 file"));
}

TEST_F(ObjectFiles, TheSameContentIsTheSameBytesLater) {
  const std::vector<CurveSeries> rods = {Rod(3)};
  const std::vector<ObjectSeries> objects = {Tumbling("a", 3, 1)};
  ASSERT_TRUE(WriteCurves(file_, rods, "test", objects).ok());
  std::this_thread::sleep_for(std::chrono::milliseconds(1100));  // HDF5 counts seconds
  ASSERT_TRUE(WriteCurves(folder_ / "later.h5", rods, "test", objects).ok());
  EXPECT_TRUE(testing_support::ReadText(file_) == testing_support::ReadText(folder_ / "later.h5"));
}

TEST_F(ObjectFiles, SlipsAreNamed) {
  const std::vector<CurveSeries> rods = {Rod(3)};
  EXPECT_THAT(WriteCurves(file_, rods, "", std::vector{Tumbling("o", 2, 1)}).error().message,
              HasSubstr("object 'o' has 2 poses"));
  EXPECT_FALSE(WriteCurves(file_, rods, "", std::vector{Tumbling("o", 3, 1), Tumbling("o", 3, 1)}).ok());
  EXPECT_FALSE(WriteCurves(file_, rods, "", std::vector{Tumbling("a/b", 3, 1)}).ok());
  EXPECT_FALSE(std::filesystem::exists(file_));

  const std::vector<ObjectSeries> two = {Tumbling("a", 3, 1), Tumbling("b", 3, 1)};
  const auto after = [&](const std::function<void(hid_t)>& change) {
    EXPECT_TRUE(WriteCurves(file_, rods, "", two).ok());
    Bend(file_, change);
    const auto read = ReadObjectsOverTime(file_);
    return read.ok() ? std::string("read") : read.error().message;
  };
  EXPECT_EQ(after([](hid_t) {}), "read");
  EXPECT_THAT(after([](hid_t f) {
                Overwrite(f, "/object/b/time", {0, 0.1, 0.3});
              }),
              HasSubstr("/object/b/time: expected the times of /object/a"));
  EXPECT_THAT(after([](hid_t f) {
                Overwrite(f, "/object/a/time", {0, 0.3, 0.2});
              }),
              HasSubstr("/object/a: time: expected times that never fall"));
  EXPECT_THAT(after([](hid_t f) { Overwrite(f, "/object/a/orientation", std::vector<double>(12, 1)); }),
              HasSubstr("/object/a: orientation: frame 0 has length 2"));
  EXPECT_THAT(after([](hid_t f) { Overwrite(f, "/object/a/force", std::vector<double>(9, NAN)); }),
              HasSubstr("/object/a: force: nan"));
  EXPECT_THAT(after([](hid_t f) { H5Ldelete(f, "/object/a/position", H5P_DEFAULT); }),
              HasSubstr("/object/a: position"));
}

TEST_F(ObjectFiles, RandomBytesInAFileNeverCrashTheReader) {
  ASSERT_TRUE(WriteCurves(file_, std::vector{Rod(3)}, "test", std::vector{Tumbling("a", 3, 1)}).ok());
  const std::string bytes = testing_support::ReadText(file_);
  std::mt19937_64 random(5);
  for (int i = 0; i < 300; ++i) {
    std::string bent = bytes;
    for (int k = 0; k < 3; ++k) bent[random() % bent.size()] = static_cast<char>(random());
    testing_support::WriteText(folder_ / "bent.h5", bent);
    const auto read = ReadObjectsOverTime(folder_ / "bent.h5");
    if (!read.ok()) {
      EXPECT_THAT(read.error().message, HasSubstr("bent.h5")) << "seed 5, case " << i;
    }
  }
}

}  // namespace
}  // namespace tendril
