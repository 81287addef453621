#include "capture/track/board.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

namespace tendril {
namespace {

constexpr const char* kExpected =
    "expected chessboard:9x6:0.025 (inner corners, m), charuco:7x5:0.04:0.03:4x4_50 (squares, m, m) or "
    "aprilgrid:6x6:0.088:0.3:2 (tags, m, gap / side, border bits)";

std::vector<std::string> Split(const std::string& text, char at) {
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == at) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

template <class T>
bool Parse(const std::string& text, T& value) {
  const char* const end = text.data() + text.size();
  const auto [stopped, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stopped == end && !text.empty();
}

}  // namespace

Result<Board> ParseBoard(const std::string& text) {
  const Error wrong{ErrorKind::kBadInput, fmt::format("board '{}' is not understood; {}", text, kExpected)};
  const std::vector<std::string> parts = Split(text, ':');
  Board board;
  if (parts.size() < 3) return wrong;
  const std::vector<std::string> counts = Split(parts[1], 'x');
  if (counts.size() != 2 || !Parse(counts[0], board.columns) || !Parse(counts[1], board.rows)) return wrong;
  if (!Parse(parts[2], board.square)) return wrong;
  if (parts[0] == "chessboard") {
    board.kind = BoardKind::kChessboard;
    if (parts.size() != 3) return wrong;
  } else if (parts[0] == "charuco") {
    board.kind = BoardKind::kCharuco;
    board.family = parts.size() > 4 ? parts[4] : "4x4_50";
    if (parts.size() < 4 || parts.size() > 5 || !Parse(parts[3], board.marker)) return wrong;
  } else if (parts[0] == "aprilgrid") {
    board.kind = BoardKind::kAprilGrid;
    board.family = "tag36h11";
    if (parts.size() < 4 || parts.size() > 5 || !Parse(parts[3], board.spacing)) return wrong;
    if (parts.size() == 5 && !Parse(parts[4], board.border_bits)) return wrong;
  } else {
    return wrong;
  }
  if (auto s = CheckBoard(board); !s.ok()) return s.error();
  return board;
}

std::string BoardText(const Board& b) {
  switch (b.kind) {
    case BoardKind::kChessboard:
      return fmt::format("chessboard:{}x{}:{}", b.columns, b.rows, b.square);
    case BoardKind::kCharuco:
      return fmt::format("charuco:{}x{}:{}:{}:{}", b.columns, b.rows, b.square, b.marker, b.family);
    case BoardKind::kAprilGrid:
      return fmt::format("aprilgrid:{}x{}:{}:{}:{}", b.columns, b.rows, b.square, b.spacing, b.border_bits);
  }
  return {};
}

Status CheckBoard(const Board& board) {
  const auto bad = [](const std::string& message) { return Error{ErrorKind::kBadInput, message}; };
  const int least = board.kind == BoardKind::kAprilGrid ? 1 : 3;
  if (board.columns < least || board.rows < least || board.columns > 100 || board.rows > 100) {
    return bad(
        fmt::format("a board of {} x {}; expected {} to 100 each way", board.columns, board.rows, least));
  }
  if (!(board.square > 0 && board.square <= 10)) {
    return bad(fmt::format("a board with squares of {} m; expected more than 0, up to 10 m", board.square));
  }
  if (board.kind == BoardKind::kCharuco) {
    if (!(board.marker > 0 && board.marker < board.square)) {
      return bad(
          fmt::format("markers of {} m in squares of {} m; expected more than 0 and less than the square",
                      board.marker, board.square));
    }
    const auto dictionary = DictionaryOf(board.family);
    if (!dictionary) {
      return bad(fmt::format("marker dictionary '{}'; expected 4x4_50 .. 7x7_1000 (50, 100, 250 or 1000)",
                             board.family));
    }
    if (board.columns * board.rows / 2 > dictionary->markers) {
      return bad(fmt::format(
          "{} x {} squares need {} markers; dictionary {} has {}; expected fewer squares or a larger "
          "dictionary",
          board.columns, board.rows, board.columns * board.rows / 2, board.family, dictionary->markers));
    }
  }
  if (board.kind == BoardKind::kAprilGrid) {
    if (!(board.spacing > 0 && board.spacing <= 2)) {
      return bad(
          fmt::format("gap / side of an AprilGrid is {}; expected more than 0, up to 2", board.spacing));
    }
    if (board.border_bits != 1 && board.border_bits != 2) {
      return bad(fmt::format("a border of {} bits; expected 1 or 2", board.border_bits));
    }
    if (board.family != "tag36h11") {
      return bad(fmt::format("an AprilGrid of family {}; expected tag36h11", board.family));
    }
    if (board.columns * board.rows > 587) {
      return bad(fmt::format("{} tags; expected up to the 587 of tag36h11", board.columns * board.rows));
    }
  }
  return Ok{};
}

Eigen::Matrix3Xd BoardPoints(const Board& board) {
  if (board.kind == BoardKind::kAprilGrid) {
    Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, 4 * board.columns * board.rows);
    const double pitch = board.square * (1 + board.spacing);
    const std::array<double, 4> right{0, 1, 1, 0};
    const std::array<double, 4> up{0, 0, 1, 1};
    for (int tag = 0; tag < board.columns * board.rows; ++tag) {
      for (int k = 0; k < 4; ++k) {
        const auto corner = static_cast<size_t>(k);
        points(0, 4 * tag + k) = pitch * (tag % board.columns) + board.square * right[corner];
        points(1, 4 * tag + k) = -(pitch * (tag / board.columns) + board.square * up[corner]);
      }
    }
    return points;
  }
  const bool chess = board.kind == BoardKind::kChessboard;
  const int across = chess ? board.columns : board.columns - 1;
  const int down = chess ? board.rows : board.rows - 1;
  const double first = chess ? 0 : board.square;
  Eigen::Matrix3Xd points = Eigen::Matrix3Xd::Zero(3, across * down);
  for (int i = 0; i < across * down; ++i) {
    points(0, i) = first + board.square * (i % across);
    points(1, i) = first + board.square * (i / across);
  }
  return points;
}

std::optional<MarkerDictionary> DictionaryOf(const std::string& name) {
  constexpr std::array<int, 4> kSizes{50, 100, 250, 1000};
  for (int bits = 4; bits <= 7; ++bits) {
    for (size_t i = 0; i < kSizes.size(); ++i) {
      if (name != fmt::format("{0}x{0}_{1}", bits, kSizes[i])) continue;
      return MarkerDictionary{4 * (bits - 4) + static_cast<int>(i), kSizes[i]};
    }
  }
  return std::nullopt;
}

bool LooksSameTurned(const Board& board) {
  return board.kind == BoardKind::kChessboard && (board.columns + board.rows) % 2 == 0;
}

}  // namespace tendril
