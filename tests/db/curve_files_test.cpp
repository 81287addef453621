// db/files/curve_files.h: round trips to the last bit, both formats; every slip named; whole files or none.
#include "db/files/curve_files.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <limits>
#include <random>

#include "tests/support/program.h"

namespace tendril {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing_support::TemporaryFolder;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

CurveSeries Series(const std::string& name, int frames, int nodes, bool whole) {
  std::mt19937_64 random(static_cast<std::uint64_t>(frames * 1000 + nodes));
  std::normal_distribution<double> normal;
  CurveSeries s;
  s.name = name;
  s.time = Eigen::VectorXd::LinSpaced(frames, 0.1, 0.1 * frames);
  for (int f = 0; f < frames; ++f) {
    FramedCurve c;
    c.points = Eigen::Matrix3Xd::NullaryExpr(3, nodes, [&] { return 1e6 * normal(random); });
    c.normals = Eigen::Matrix3Xd::NullaryExpr(3, nodes, [&] { return normal(random); });
    c.normals.colwise().normalize();
    s.curves.push_back(c);
    if (!whole) continue;
    s.sigma.emplace_back(Eigen::VectorXd::NullaryExpr(nodes, [&] { return std::abs(normal(random)); }));
    s.sigma.back()[0] = kNaN;
    s.interpolated.emplace_back(
        Eigen::VectorXi::NullaryExpr(nodes, [&] { return static_cast<int>(random() % 2); }));
    s.covariance_factor.emplace_back(
        Eigen::MatrixXd::NullaryExpr(3 * nodes, 4, [&] { return normal(random); }));
    s.turn_factor.emplace_back(
        Eigen::MatrixXd::NullaryExpr(nodes, 4 + nodes, [&] { return normal(random); }));
    for (auto* values : {&s.angle, &s.angle_sigma, &s.angle_by_pictures})
      values->emplace_back(Eigen::VectorXd::NullaryExpr(nodes - 1, [&] { return normal(random); }));
  }
  return s;
}

bool Same(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         ((a.array() == b.array()) || (a.array().isNaN() && b.array().isNaN())).all();
}

void ExpectSame(const CurveSeries& a, const CurveSeries& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_TRUE(Same(a.time, b.time));
  ASSERT_EQ(a.curves.size(), b.curves.size());
  ASSERT_EQ(a.sigma.size(), b.sigma.size());
  ASSERT_EQ(a.interpolated.size(), b.interpolated.size());
  ASSERT_EQ(a.covariance_factor.size(), b.covariance_factor.size());
  ASSERT_EQ(a.turn_factor.size(), b.turn_factor.size());
  for (size_t f = 0; f < a.curves.size(); ++f) {
    EXPECT_TRUE(Same(a.curves[f].points, b.curves[f].points));
    EXPECT_TRUE(Same(a.curves[f].normals, b.curves[f].normals));
    if (!a.sigma.empty()) {
      EXPECT_TRUE(Same(a.sigma[f], b.sigma[f]));
    }
    if (!a.interpolated.empty()) {
      EXPECT_EQ(a.interpolated[f], b.interpolated[f]);
    }
    for (const auto values :
         {&CurveSeries::angle, &CurveSeries::angle_sigma, &CurveSeries::angle_by_pictures}) {
      ASSERT_EQ((a.*values).size(), (b.*values).size());
      if (!(a.*values).empty()) {
        EXPECT_TRUE(Same((a.*values)[f], (b.*values)[f]));
      }
    }
    if (!a.covariance_factor.empty()) {
      EXPECT_TRUE(Same(a.covariance_factor[f], b.covariance_factor[f]));
    }
    if (!a.turn_factor.empty()) {
      EXPECT_TRUE(Same(a.turn_factor[f], b.turn_factor[f]));
    }
  }
}

void ExpectRoundTrip(const std::string& file, const std::vector<CurveSeries>& curves) {
  const Status written = WriteCurves(file, curves, "test");
  ASSERT_TRUE(written.ok()) << written.error().message;
  const auto read = ReadCurves(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().size(), curves.size());
  for (size_t i = 0; i < curves.size(); ++i) ExpectSame(read.value()[i], curves[i]);
}

class CurveFiles : public testing::Test {
 protected:
  std::string Csv(const std::string& text) {
    testing_support::WriteText(folder_ / "c.csv", text);
    return folder_ / "c.csv";
  }
  std::string CsvError(const std::string& text) {
    const auto read = ReadCurves(Csv(text));
    return read.ok() ? "" : read.error().message;
  }
  TemporaryFolder folder_;
};

TEST_F(CurveFiles, BothFormatsKeepEveryBitAndTheOrder) {
  const std::vector<CurveSeries> plain = {Series("tip b", 3, 5, false), Series("a", 3, 7, false)};
  ExpectRoundTrip(folder_ / "c.csv", plain);
  ExpectRoundTrip(folder_ / "c.h5", plain);
  ExpectRoundTrip(folder_ / "whole.h5", {Series("z", 4, 5, true), Series("a", 2, 3, true)});
  ExpectRoundTrip(folder_ / "one.h5", {Series("one", 1, 1, true)});
  ExpectRoundTrip(folder_ / "one.csv", {Series("one", 1, 1, false)});
  ExpectRoundTrip(folder_ / "none.h5", {Series("no frames", 0, 0, false)});
}

TEST_F(CurveFiles, TurnsKeepWhatTheyShareWithACovarianceOfFewerColumns) {
  std::vector<CurveSeries> curves = {Series("a", 2, 3, true)};
  CurveSeries& a = curves[0];
  a.covariance_factor[1] = a.covariance_factor[1].leftCols(2).eval();
  a.turn_factor[1] = a.turn_factor[1].leftCols(3).eval();
  ASSERT_TRUE(WriteCurves(folder_ / "c.h5", curves, "test").ok());
  const CurveSeries b = ReadCurves(folder_ / "c.h5").value()[0];
  const auto both = [](const CurveSeries& s, Eigen::Index columns) {
    return Eigen::MatrixXd(s.covariance_factor[1] * s.turn_factor[1].leftCols(columns).transpose());
  };
  EXPECT_LT((both(a, 2) - both(b, 4)).norm(), 1e-12);
  EXPECT_LT(
      (a.turn_factor[1] * a.turn_factor[1].transpose() - b.turn_factor[1] * b.turn_factor[1].transpose())
          .norm(),
      1e-12);
}

TEST_F(CurveFiles, GapsLiveInHdf5AndCsvRefusesThem) {
  std::vector<CurveSeries> gap = {Series("a", 2, 3, false)};
  gap[0].curves[1].points.col(2).setConstant(kNaN);
  ExpectRoundTrip(folder_ / "c.h5", gap);
  const Status csv = WriteCurves(folder_ / "c.csv", gap, "test");
  ASSERT_FALSE(csv.ok());
  EXPECT_THAT(csv.error().message, AllOf(HasSubstr("gap in frame 1"), HasSubstr(".h5")));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "c.csv"));
}

TEST_F(CurveFiles, ThePlainCsvOfTheFormatIsOneFrameAtTimeZero) {
  const auto read = ReadCurves(Csv("curve,node,x,y,z\na,0,0,0,0\na,1,1,0,-2.5e-1\nb,0,1,2,3"));
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read.value().size(), 2U);
  EXPECT_EQ(read.value()[0].curves[0].points.col(1), Eigen::Vector3d(1, 0, -0.25));
  EXPECT_EQ(read.value()[0].curves[0].normals.cols(), 0);
  EXPECT_EQ(read.value()[0].time, Eigen::VectorXd::Zero(1));
  EXPECT_EQ(read.value()[1].name, "b");
}

TEST_F(CurveFiles, CsvRowsMayBeSortedByFrameOrByCurveWithAnyLineEnd) {
  const std::string head = "frame,time,curve,node,x,y,z\n";
  const auto by_frame =
      ReadCurves(Csv(head + "0,0,a,0,1,0,0\r\n0,0,b,0,2,0,0\r\n5,0.5,a,0,3,0,0\r\n5,0.5,b,0,4,0,0\r\n"));
  ASSERT_TRUE(by_frame.ok()) << by_frame.error().message;
  const auto by_curve = ReadCurves(Csv(
      "\xEF\xBB\xBF" + head + "0,0,a,0,1,0,0\n5,0.5,a,0,3,0,0\n\n0, 0, b, 0, 2, 0, 0\n5,0.5,b,0,4,0,0\n"));
  ASSERT_TRUE(by_curve.ok()) << by_curve.error().message;
  for (size_t i = 0; i < 2; ++i) ExpectSame(by_frame.value()[i], by_curve.value()[i]);
  EXPECT_EQ(by_frame.value()[1].curves[1].points(0, 0), 4);
}

TEST_F(CurveFiles, EachSlipOfACsvIsOneLineWithPlaceFieldAndWhatWasExpected) {
  const std::string head = "curve,node,x,y,z\n";
  EXPECT_THAT(CsvError(""), HasSubstr("c.csv: empty, expected the header curve,node,x,y,z"));
  EXPECT_THAT(CsvError(head), HasSubstr("holds no curve"));
  EXPECT_THAT(CsvError("curve,node,x,y\na,0,1,2\n"), HasSubstr("c.csv:1: header is 'curve,node,x,y'"));
  EXPECT_THAT(CsvError(head + "a,0,0,0,0\na,2,1,1,1\n"), HasSubstr("c.csv:3: node = '2': expected 1"));
  EXPECT_THAT(CsvError(head + "a,1,0,0,0\n"), HasSubstr("c.csv:2: node = '1': expected 0"));
  EXPECT_THAT(CsvError(head + "a,0,nan,0,0\n"), HasSubstr("c.csv:2: x = 'nan': expected a number"));
  EXPECT_THAT(CsvError(head + "a,0,1e999,0,0\n"), HasSubstr("x = '1e999': expected a number"));
  EXPECT_THAT(CsvError(head + "a,0,0,0,north\n"), HasSubstr("z = 'north': expected a number"));
  EXPECT_THAT(CsvError(head + "a,0,0,0,\n"), HasSubstr("z = '': expected a number"));
  EXPECT_THAT(CsvError(head + "a,0,0,0\n"), HasSubstr("c.csv:2: 'a,0,0,0' has 4 fields, expected 5"));
  EXPECT_THAT(CsvError(head + ",0,0,0,0\n"), HasSubstr("curve = '': expected a name"));
  EXPECT_THAT(CsvError("curve,node,x,y,z,nx,ny,nz\na,0,0,0,0,0,0,2\n"), HasSubstr("expected a unit vector"));
  const std::string timed = "frame,time,curve,node,x,y,z\n";
  EXPECT_THAT(CsvError(timed + "0,0,a,0,0,0,0\n0,0,a,1,0,0,1\n1,1,a,0,0,0,0\n"),
              AllOf(HasSubstr("1 nodes in frame 1"), HasSubstr("truncated?")));
  EXPECT_THAT(CsvError(timed + "0,0,a,0,0,0,0\n0,0,b,0,0,0,1\n1,1,a,0,0,0,0\n"), HasSubstr("same frames"));
  EXPECT_THAT(CsvError(timed + "1,1,a,0,0,0,0\n0,0,a,0,0,0,1\n"), HasSubstr("expected a frame after 1"));
  EXPECT_THAT(CsvError(timed + "0,1,a,0,0,0,0\n1,0,a,0,0,0,1\n"),
              HasSubstr("time = '0': expected at least 1 s"));
  EXPECT_THAT(CsvError(timed + "0,0,a,0,0,0,0\n0,1,a,1,0,0,1\n"), HasSubstr("as in the rest of frame 0"));
}

TEST_F(CurveFiles, ACsvCutAnywhereIsAnErrorOrAWholeNumberOfRows) {
  const std::vector<CurveSeries> curves = {Series("a", 2, 2, false)};
  ASSERT_TRUE(WriteCurves(folder_ / "whole.csv", curves, "test").ok());
  const std::string text = testing_support::ReadText(folder_ / "whole.csv");
  for (size_t length = 0; length + 30 < text.size(); ++length) {
    const auto read = ReadCurves(Csv(text.substr(0, length)));
    if (!read.ok()) continue;
    // What is left may be a whole first frame; its last number may have lost digits, never a node.
    EXPECT_EQ(read.value()[0].curves.back().points.cols(), read.value()[0].curves.front().points.cols());
  }
}

TEST_F(CurveFiles, AnHdf5FileCutAnywhereIsAnError) {
  const std::string file = folder_ / "c.h5";
  ASSERT_TRUE(WriteCurves(file, std::vector{Series("a", 3, 5, true)}, "test").ok());
  const std::string bytes = testing_support::ReadText(file);
  for (size_t length = 0; length < bytes.size(); length += 97) {
    testing_support::WriteText(folder_ / "cut.h5", bytes.substr(0, length));
    const auto read = ReadCurves(folder_ / "cut.h5");
    ASSERT_FALSE(read.ok()) << length << " of " << bytes.size();
    EXPECT_EQ(read.error().kind, ErrorKind::kBadInput);
    EXPECT_THAT(read.error().message, HasSubstr("cut.h5"));
  }
}

TEST_F(CurveFiles, AnHdf5FileWithRandomBytesInItNeverCrashes) {
  const std::string file = folder_ / "c.h5";
  ASSERT_TRUE(WriteCurves(file, std::vector{Series("a", 2, 3, true)}, "test").ok());
  const std::string bytes = testing_support::ReadText(file);
  std::mt19937_64 random(11);
  for (int i = 0; i < 300; ++i) {
    std::string bent = bytes;
    for (int k = 0; k < 3; ++k) bent[random() % bent.size()] = static_cast<char>(random());
    testing_support::WriteText(folder_ / "bent.h5", bent);
    const auto read = ReadCurves(folder_ / "bent.h5");
    if (!read.ok()) {
      EXPECT_THAT(read.error().message, HasSubstr("bent.h5")) << "seed 11, case " << i;
    }
  }
}

// A file as another program might write it: one curve, `points` of a shape and unit of its own.
void WriteForeign(const std::string& file, const std::vector<hsize_t>& shape,
                  const std::vector<double>& values, bool time) {
  const hid_t f = H5Fcreate(file.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t all = H5Gcreate2(f, "curve", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const hid_t one = H5Gcreate2(all, "a", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  const auto add = [&](const char* name, const std::vector<hsize_t>& dims, const std::vector<double>& data) {
    const hid_t space = H5Screate_simple(static_cast<int>(dims.size()), dims.data(), nullptr);
    const hid_t set = H5Dcreate2(one, name, H5T_NATIVE_FLOAT, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dwrite(set, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, data.data());
    H5Dclose(set);
    H5Sclose(space);
  };
  add("points", shape, values);
  if (time) add("time", {shape[0]}, std::vector<double>(shape[0], 0.0));
  H5Gclose(one);
  H5Gclose(all);
  H5Fclose(f);
}

TEST_F(CurveFiles, ForeignHdf5IsReadWhereItFitsAndNamedWhereNot) {
  const std::string file = folder_ / "f.h5";
  WriteForeign(file, {1, 2, 3}, {0, 0, 0, 1, 2, 3}, true);  // single precision, no attributes
  const auto read = ReadCurves(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value()[0].curves[0].points.col(1), Eigen::Vector3d(1, 2, 3));
  WriteForeign(file, {1, 3, 2}, {0, 0, 0, 1, 2, 3}, true);
  EXPECT_THAT(ReadCurves(file).error().message,
              HasSubstr("f.h5: /curve/a/points: shape [1, 3, 2]: expected [any, any, 3]"));
  WriteForeign(file, {1, 2, 3}, {0, 0, 0, 1, 2, 3}, false);
  EXPECT_THAT(ReadCurves(file).error().message, HasSubstr("/curve/a/time: cannot be opened"));
  WriteForeign(file, {1, 2, 3}, {0, 0, INFINITY, 1, 2, 3}, true);
  EXPECT_THAT(ReadCurves(file).error().message, HasSubstr("frame 0, node 0 is infinite"));
}

TEST_F(CurveFiles, SizesAndNamesThatDoNotAgreeAreRefusedBeforeWriting) {
  CurveSeries s = Series("a", 2, 3, true);
  s.sigma.pop_back();
  EXPECT_THAT(WriteCurves(folder_ / "c.h5", std::vector{s}, "").error().message,
              HasSubstr("1 sigma entries"));
  s = Series("a", 2, 3, true);
  s.angle[1].resize(3);
  EXPECT_THAT(WriteCurves(folder_ / "c.h5", std::vector{s}, "").error().message,
              HasSubstr("3 angles for 3 nodes, expected one less"));
  s = Series("a", 2, 3, false);
  s.curves[1].points.resize(3, 2);
  EXPECT_THAT(WriteCurves(folder_ / "c.h5", std::vector{s}, "").error().message,
              HasSubstr("2 nodes, after 3"));
  for (const std::string name : {"", "a,b", "a/b", "a\nb", ".."}) {
    EXPECT_FALSE(WriteCurves(folder_ / "c.h5", std::vector{Series(name, 1, 2, false)}, "").ok()) << name;
  }
  EXPECT_FALSE(
      WriteCurves(folder_ / "c.h5", std::vector{Series("a", 1, 2, false), Series("a", 1, 2, false)}, "")
          .ok());
  EXPECT_THAT(WriteCurves(folder_ / "c.txt", std::vector{Series("a", 1, 2, false)}, "").error().message,
              HasSubstr("expected .csv, .h5 or .hdf5"));
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(CurveFiles, AFullDiskLeavesNoHdf5FileAndNoPieceOfOne) {
  const auto before_signal = std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit small{3000, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &small);
  const Status full = WriteCurves(folder_ / "c.h5", std::vector{Series("a", 50, 50, true)}, "test");
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, before_signal);
  ASSERT_FALSE(full.ok());
  EXPECT_EQ(full.error().kind, ErrorKind::kIo);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

}  // namespace
}  // namespace tendril
