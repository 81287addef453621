#include "db/files/recording_logs.h"

#include <fmt/format.h>

#include <cmath>
#include <iterator>

#include "db/files/csv_read.h"
#include "db/files/safe_file.h"

namespace tendril {
namespace {

constexpr const char* kFrameHeader = "frame,frame_id,device_ns,host_ns,status,dropped_before";
constexpr const char* kServoHeader =
    "host_ns,device_ms,servo,command,position_deg,current_mA,voltage_V,temperature_degC";
constexpr const char* kDetectionHeader = "camera,frame,tag,hamming,margin,x0,y0,x1,y1,x2,y2,x3,y3,sigma_px";
constexpr const char* kOlderDetectionHeader = "camera,frame,tag,hamming,margin,x0,y0,x1,y1,x2,y2,x3,y3";
constexpr const char* kResidualHeader = "camera,frame,tag,used,x0,y0,x1,y1,x2,y2,x3,y3";
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

template <class Value>
std::string Cell(const std::optional<Value>& value) {
  return value ? fmt::format("{}", *value) : std::string();
}
std::string Cell(double value) { return std::isnan(value) ? std::string() : fmt::format("{}", value); }

// Any plain name will do; a comma or line break would tear the row.
bool IsPlain(const std::string& text) {
  return text.find_first_of(",\r\n") == std::string::npos && !text.empty();
}

}  // namespace

std::string FrameLogHeader() { return std::string(kFrameHeader) + "\n"; }
std::string ServoLogHeader() { return std::string(kServoHeader) + "\n"; }

std::string FrameLogLine(const FrameRow& row) {
  return fmt::format("{},{},{},{},{},{}\n", row.frame, row.frame_id, row.device_ns, row.host_ns, row.status,
                     row.dropped_before);
}

std::string ServoLogLine(const ServoRow& row) {
  return fmt::format("{},{},{},{},{},{},{},{}\n", row.host_ns, Cell(row.device_ms), row.servo,
                     Cell(row.command), Cell(row.position_deg), Cell(row.current_mA), Cell(row.voltage_V),
                     Cell(row.temperature_degC));
}

Result<std::vector<FrameRow>> ReadFrameLog(const std::filesystem::path& file) {
  auto opened = CsvReader::Open(file, {kFrameHeader}, /*lines_end=*/true);
  if (!opened.ok()) return opened.error();
  CsvReader& csv = opened.value();
  std::vector<FrameRow> rows;
  while (csv.Next()) {
    FrameRow row;
    row.frame = csv.Integer(0, 0);
    row.frame_id = csv.Integer(1);
    row.device_ns = csv.Integer(2);
    row.host_ns = csv.Integer(3);
    row.status = csv.Text(4);
    row.dropped_before = csv.Integer(5, 0);
    if (row.status.empty()) csv.Reject(4, "a status such as ok");
    const auto next = static_cast<std::int64_t>(rows.size());
    if (row.frame != next) csv.Reject(0, fmt::format("{}, for frames run 0, 1, 2, ...", next));
    if (!rows.empty() && row.frame_id < rows.back().frame_id) {
      csv.Reject(1, fmt::format("at least {}, that of the frame before", rows.back().frame_id));
    }
    if (!rows.empty() && row.host_ns < rows.back().host_ns) {
      csv.Reject(3, fmt::format("at least {}, that of the frame before", rows.back().host_ns));
    }
    rows.push_back(std::move(row));
  }
  if (!csv.ok()) return csv.status().error();
  return rows;
}

Result<std::vector<ServoRow>> ReadServoLog(const std::filesystem::path& file) {
  auto opened = CsvReader::Open(file, {kServoHeader}, /*lines_end=*/true);
  if (!opened.ok()) return opened.error();
  CsvReader& csv = opened.value();
  std::vector<ServoRow> rows;
  while (csv.Next()) {
    ServoRow row;
    row.host_ns = csv.Integer(0);
    row.device_ms = csv.IntegerOrEmpty(1);
    row.servo = static_cast<int>(csv.Integer(2, 0, INT32_MAX));
    row.command = csv.NumberOrEmpty(3);
    row.position_deg = csv.NumberOrEmpty(4);
    row.current_mA = csv.NumberOrEmpty(5);
    row.voltage_V = csv.NumberOrEmpty(6);
    row.temperature_degC = csv.NumberOrEmpty(7);
    rows.push_back(row);
  }
  if (!csv.ok()) return csv.status().error();
  return rows;
}

Result<std::vector<DetectionRow>> ReadDetections(const std::filesystem::path& file) {
  auto opened = CsvReader::Open(file, {kDetectionHeader, kOlderDetectionHeader}, /*lines_end=*/true);
  if (!opened.ok()) return opened.error();
  CsvReader& csv = opened.value();
  std::vector<DetectionRow> rows;
  while (csv.Next()) {
    DetectionRow row;
    row.camera = static_cast<int>(csv.Integer(0, 0, INT32_MAX));
    row.frame = csv.Integer(1, 0);
    row.tag = static_cast<int>(csv.Integer(2, 0, INT32_MAX));
    if (!csv.Text(3).empty()) row.hamming = static_cast<int>(csv.Integer(3, 0, INT32_MAX));
    row.margin = csv.NumberOrEmpty(4).value_or(kNone);
    size_t column = 5;
    for (int corner = 0; corner < 4; ++corner, column += 2) {
      row.corners_px(0, corner) = csv.Number(column);
      row.corners_px(1, corner) = csv.Number(column + 1);
    }
    if (csv.columns().size() > column) row.sigma_px = csv.NumberOrEmpty(column).value_or(kNone);
    rows.push_back(row);
  }
  if (!csv.ok()) return csv.status().error();
  return rows;
}

Result<std::vector<ResidualRow>> ReadResiduals(const std::filesystem::path& file) {
  auto opened = CsvReader::Open(file, {kResidualHeader}, /*lines_end=*/true);
  if (!opened.ok()) return opened.error();
  CsvReader& csv = opened.value();
  std::vector<ResidualRow> rows;
  while (csv.Next()) {
    ResidualRow row;
    row.camera = static_cast<int>(csv.Integer(0, 0, INT32_MAX));
    row.frame = csv.Integer(1, 0);
    row.tag = static_cast<int>(csv.Integer(2, 0, INT32_MAX));
    row.used = csv.Integer(3, 0, 1) == 1;
    for (int k = 0; k < 8; ++k) {
      row.corners_px(k % 2, k / 2) = csv.NumberOrEmpty(static_cast<size_t>(4 + k)).value_or(kNone);
    }
    rows.push_back(row);
  }
  if (!csv.ok()) return csv.status().error();
  return rows;
}

Status WriteFrameLog(const std::filesystem::path& file, std::span<const FrameRow> rows) {
  std::string text = FrameLogHeader();
  for (const FrameRow& row : rows) {
    if (!IsPlain(row.status)) {
      return Error{ErrorKind::kBadInput, fmt::format("{}: frame {}: status '{}': expected a word, no comma",
                                                     file.string(), row.frame, row.status)};
    }
    text += FrameLogLine(row);
  }
  return WriteText(file, text);
}

Status WriteServoLog(const std::filesystem::path& file, std::span<const ServoRow> rows) {
  std::string text = ServoLogHeader();
  for (const ServoRow& row : rows) text += ServoLogLine(row);
  return WriteText(file, text);
}

Status WriteDetections(const std::filesystem::path& file, std::span<const DetectionRow> rows) {
  std::string text = std::string(kDetectionHeader) + "\n";
  for (const DetectionRow& row : rows) {
    fmt::format_to(std::back_inserter(text), "{},{},{},{},{}", row.camera, row.frame, row.tag,
                   Cell(row.hamming), Cell(row.margin));
    for (int corner = 0; corner < 4; ++corner) {
      fmt::format_to(std::back_inserter(text), ",{},{}", row.corners_px(0, corner),
                     row.corners_px(1, corner));
    }
    fmt::format_to(std::back_inserter(text), ",{}\n", Cell(row.sigma_px));
  }
  return WriteText(file, text);
}

Status WriteResiduals(const std::filesystem::path& file, std::span<const ResidualRow> rows) {
  std::string text = std::string(kResidualHeader) + "\n";
  for (const ResidualRow& row : rows) {
    fmt::format_to(std::back_inserter(text), "{},{},{},{}", row.camera, row.frame, row.tag, row.used ? 1 : 0);
    for (int k = 0; k < 8; ++k) {
      fmt::format_to(std::back_inserter(text), ",{}", Cell(row.corners_px(k % 2, k / 2)));
    }
    text += '\n';
  }
  return WriteText(file, text);
}

}  // namespace tendril
