#pragma once
// Which pictures belong together, and the boards in them: files, folders and videos of several cameras as
// views with stamps.

#include <string>
#include <vector>

#include "calibrate/cameras/bundle.h"
#include "capture/track/board.h"
#include "model/progress.h"

namespace tendril {

// One camera's pictures: files, a folder, patterns whose last part has * or ?, or one video.
struct CameraPictures {
  std::string name;
  std::vector<std::string> sources;
};

struct BoardsSeen {
  std::vector<Camera> cameras;     // names and sizes
  std::vector<BoardView> views;    // target 0
  std::vector<int> pictures;       // looked at, by camera
  std::vector<std::string> notes;  // pictures without a board, and how stamps were chosen
};

// Whether every camera's source is a video, by its name.
bool AreVideos(const std::vector<CameraPictures>& cameras);

// Stamps: of videos, of frames that were taken at once, by the frame logs beside them (cam0.csv of cam0.mkv);
// the frame's number where one has none. Of files, the last number in their names where all of a camera's
// differ in it, else their order (then all cameras need equally many).
//   every   of videos, each so manieth frame
//   errors  kBadInput  a picture that is none, or of another size than the camera's first; names without
//                      numbers and unequal counts
//           kNotFound  no such file; a pattern that nothing matches
//           kStopped   progress said so
Result<BoardsSeen> FindBoards(const std::vector<CameraPictures>& cameras, const Board& board, int every = 1,
                              const Progress& progress = {});

}  // namespace tendril
