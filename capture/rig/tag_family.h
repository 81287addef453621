#pragma once
// The tag families of Debian's libapriltag: their geometry and what each tag looks like.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "model/result.h"

struct apriltag_family;

namespace tendril {

// Widths in modules (cells of the printed pattern).
struct TagFamily {
  std::string name;
  int ids = 0;
  int bits = 0;
  int hamming = 0;       // bits in which any two tags differ at least
  int border_width = 0;  // between the corners that the detector reports
  int total_width = 0;   // printed pattern with its outermost ring
  int void_width = 0;    // of the square in the middle that carries no bit
  bool round = false;    // a disc, not a square
  bool reversed_border =
      false;  // the quad is light around dark data (Standard, Circle, Custom), not dark on light
};

// Names that FamilyOf knows, best known first.
std::vector<std::string> TagFamilyNames();

//   errors  kBadInput: no family of this name (lists those there are)
Result<TagFamily> FamilyOf(const std::string& name);

// The printed pattern of one tag as libapriltag draws it, top row first; 0 black, 255 white.
// (total_width, total_width)
//   errors  kBadInput: as FamilyOf; no such id
using TagPattern = Eigen::Matrix<unsigned char, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
Result<TagPattern> PatternOf(const std::string& family, int id);

// For code that calls libapriltag itself: the library's own struct, to be given back to DestroyFamily; null
// for an unknown name.
apriltag_family* CreateFamily(const std::string& name);
void DestroyFamily(apriltag_family* family);

}  // namespace tendril
