#pragma once
// Which corners of a calibration board a picture shows, and where.
//
// Pixels: (0, 0) is the centre of the top left pixel.

#include <Eigen/Core>
#include <vector>

#include "capture/track/board.h"
#include "capture/track/tag_detect.h"
#include "model/result.h"

namespace tendril {

struct BoardCorners {
  std::vector<int> ids;     // corners' numbers (capture/track/board.h), each once; empty: no board seen
  Eigen::Matrix2Xd pixels;  // where they are, px   (2, ids)
};

// A chessboard is seen whole or not at all; of the other boards, what is seen. Corners are refined to the
// saddle of the brightness around them, in a square of half side 0.3 of the distance to their nearest
// neighbour: a wider one reaches other corners where the board is tilted (on real boards that doubles the
// reprojection error), a smaller one uses less of the edges.
//
// A chessboard whose corners across and down are one even and one odd has a first corner (its neighbouring
// inner square is black); of others the one nearest to the picture's top left is taken.
//
// AprilGrids with a border of 1 bit are read by libapriltag, of 2 bits (Kalibr's) by OpenCV.
//   errors  kBadInput: a board or picture that is none
Result<BoardCorners> DetectBoard(const GrayImage& image, const Board& board);

}  // namespace tendril
