#pragma once
// Tags as what cameras are calibrated with: each for itself, or many that are fixed to each other at places
// that nobody measured (a wall, a box, a sheet of tags).
//
// Scale comes from the tags' stated size, so lenses must be known, if roughly.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "calibrate/cameras/bundle.h"

namespace tendril {

struct TagInPicture {
  std::int64_t stamp = 0;  // pictures of equal stamp were taken at once; any unit
  int tag = 0;
  int camera = 0;
  Eigen::Matrix<double, 2, 4> corners_px;  // in the detector's order
};

// A tag with the velocity of its corners, from the same camera's pictures just before and after.
struct MovingTag {
  TagInPicture seen;
  Eigen::Matrix<double, 2, 4> velocity;  // px per unit of stamp
  double px_per_picture = 0;             // mean over the corners
};

// Tags that are also in the pictures before and after; not where pictures are missing between.
std::vector<MovingTag> MotionOf(std::span<const TagInPicture> tags);

// For cameras that are not triggered together. Pictures whose tags move less than `fastest` px from picture
// to picture keep their stamp; of the others up to `most_alone` per camera, spread evenly, get a stamp of
// their own (negative, so theirs must not be): they tell about a lens and about what the tags are fixed to,
// not about where cameras stand to each other.
std::vector<TagInPicture> UnlinkMoving(std::span<const TagInPicture> tags, double fastest,
                                       int most_alone = 60);

// Every tag at every moment as a board of its own (TagCorners3d), for tags that move against each other.
std::vector<BoardView> ViewsOfTags(std::span<const TagInPicture> tags);

// Tags that are fixed to each other.
struct TagBody {
  std::vector<int> tags;    // ids, rising
  Eigen::Matrix3Xd points;  // corners of tags[i] at 4 i .. 4 i + 3, in the frame of tags[0], m  (3, 4 tags)
  double rms_px = 0;        // of the pictures that it comes from
  int pictures = 0;
};

struct TagBodyOptions {
  double border = 0;       // side of the tags' black border, m
  int most_pictures = 60;  // chosen so that each tag is in many; cost grows with their square
};

// Where the tags are to each other, from pictures that show several: pictures are placed about tags as
// cameras are about boards (StartRig), then all is adjusted at once, lenses as given. Pictures need not be of
// equal stamp.
//   errors  kBadInput     border <= 0, a camera number out of range
//           kUnreachable  no picture shows two tags; tags that no chain of pictures links to the others
//           (names
//                         them)
Result<TagBody> FindTagBody(const std::vector<Camera>& lenses, std::span<const TagInPicture> tags,
                            const TagBodyOptions& options);

// Each picture's tags as one view of the body; tags that it lacks are left out.
std::vector<BoardView> ViewsOfBody(const TagBody& body, std::span<const TagInPicture> tags);

}  // namespace tendril
