#pragma once
// What a calibration board is, and where its corners lie on it.
//
// Board frame: seen from the front x right, y down, z into the board (as for tags); m. Its origin is the
// first corner of a chessboard, the top left corner of a ChArUco board, tag 0's bottom left of an AprilGrid.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "model/result.h"

namespace tendril {

enum class BoardKind {
  kChessboard,
  kCharuco,    // a chessboard with a marker in each white square: parts of it suffice
  kAprilGrid,  // tags in rows from the bottom left, id 0 first (Kalibr's)
};

struct Board {
  BoardKind kind = BoardKind::kChessboard;
  int columns = 0;       // chessboard: inner corners; ChArUco: squares; AprilGrid: tags
  int rows = 0;          // likewise
  double square = 0;     // side of a square, or of a tag's black border, m
  double marker = 0;     // ChArUco: side of a marker, m
  double spacing = 0.3;  // AprilGrid: gap between neighbouring tags / side of a tag
  int border_bits = 2;   // AprilGrid: width of the black border, bits: 1 or 2
  std::string family;    // AprilGrid: "tag36h11"; ChArUco: OpenCV's name, "4x4_50"
};

// A board as a person writes it:
//   chessboard:9x6:0.025              inner corners across x down, side of a square (m)
//   charuco:7x5:0.04:0.03[:4x4_50]    squares, side of a square, of a marker (m), dictionary
//   aprilgrid:6x6:0.088:0.3[:1|2]     tags, side (m), gap / side, bits of the border (default 2); tag36h11
//   errors  kBadInput: what is wrong and what would do
Result<Board> ParseBoard(const std::string& text);
std::string BoardText(const Board& board);

//   errors  kBadInput: a count, length or name out of range
Status CheckBoard(const Board& board);

// Every corner that the board can show, by its number; z = 0, m   (3, corners). Numbers: a chessboard's and a
// ChArUco board's inner corners row by row from the top left; an AprilGrid's 4 tag + corner, in the
// detector's order (bottom left, bottom right, top right, top left).
Eigen::Matrix3Xd BoardPoints(const Board& board);

// A ChArUco board's dictionary by name ("4x4_50" .. "7x7_1000"): OpenCV's number of it, how many markers.
struct MarkerDictionary {
  int number = 0;
  int markers = 0;
};
std::optional<MarkerDictionary> DictionaryOf(const std::string& name);

// Whether the board looks the same after half a turn, so that nobody can tell which corner is the first.
bool LooksSameTurned(const Board& board);

}  // namespace tendril
