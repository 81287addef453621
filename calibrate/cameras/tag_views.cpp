#include "calibrate/cameras/tag_views.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <numeric>
#include <set>
#include <tuple>

#include "calibrate/cameras/start_values.h"
#include "capture/track/tag_pose.h"
#include "model/median.h"

namespace tendril {
namespace {

using Picture = std::vector<const TagInPicture*>;  // of one camera at one stamp

std::vector<Picture> GroupByPicture(std::span<const TagInPicture> tags) {
  std::map<std::pair<std::int64_t, int>, std::map<int, const TagInPicture*>> groups;
  for (const TagInPicture& tag : tags) groups[{tag.stamp, tag.camera}][tag.tag] = &tag;
  std::vector<Picture> pictures;
  for (const auto& [key, group] : groups) {
    pictures.emplace_back();
    for (const auto& [id, tag] : group) pictures.back().push_back(tag);
  }
  return pictures;
}

// Tags in sets: two in one picture are in one set.
class LinkedTags {
 public:
  // Whether the picture joins sets that were apart, or has a new tag.
  bool Add(const Picture& picture) {
    bool news = false;
    for (const TagInPicture* tag : picture) news = set_of_.emplace(tag->tag, tag->tag).second || news;
    const int into = set_of_[picture[0]->tag];
    for (const TagInPicture* tag : picture) {
      const int from = set_of_[tag->tag];
      if (from == into) continue;
      news = true;
      for (auto& [id, set] : set_of_) {
        if (set == from) set = into;
      }
    }
    return news;
  }
  // Tags in another set than the largest.
  std::vector<int> Apart() const {
    std::map<int, int> sizes;
    for (const auto& [id, set] : set_of_) ++sizes[set];
    const auto largest = std::max_element(sizes.begin(), sizes.end(),
                                          [](const auto& a, const auto& b) { return a.second < b.second; });
    std::vector<int> apart;
    for (const auto& [id, set] : set_of_) {
      if (set != largest->first) apart.push_back(id);
    }
    return apart;
  }

 private:
  std::map<int, int> set_of_;
};

// Pictures that link all tags, then those with the tags that few others have.
std::vector<Picture> Choose(std::vector<Picture> pictures, int most) {
  std::stable_sort(pictures.begin(), pictures.end(),
                   [](const Picture& a, const Picture& b) { return a.size() > b.size(); });
  std::vector<bool> taken(pictures.size(), false);
  std::map<int, int> count;
  std::vector<Picture> chosen;
  const auto take = [&](size_t i) {
    taken[i] = true;
    for (const TagInPicture* tag : pictures[i]) ++count[tag->tag];
    chosen.push_back(pictures[i]);
  };
  LinkedTags linked;
  for (size_t i = 0; i < pictures.size(); ++i) {
    if (linked.Add(pictures[i])) take(i);
  }
  while (static_cast<int>(chosen.size()) < most) {
    double best = 0;
    size_t next = 0;
    for (size_t i = 0; i < pictures.size(); ++i) {
      if (taken[i]) continue;
      double worth = 0;
      for (const TagInPicture* tag : pictures[i]) worth += 1.0 / (1 + count[tag->tag]);
      if (worth <= best) continue;
      best = worth;
      next = i;
    }
    if (best == 0) break;
    take(next);
  }
  return chosen;
}

// One sigma for all pictures: one of few tags says little of its own. Those that are met much worse than most
// were begun in a wrong place and are left out.
void WeighPictures(Bundle& bundle) {
  MeasureSigma(bundle);
  const double usual = Median(bundle.sigma_px);
  for (BoardPlace& tag : bundle.places) {
    std::vector<const BoardView*> kept;
    for (const BoardView* view : tag.views) {
      if (bundle.sigma_px[static_cast<size_t>(view->camera)] < 4 * usual) kept.push_back(view);
    }
    if (!kept.empty()) tag.views = std::move(kept);
  }
  bundle.sigma_px.assign(bundle.sigma_px.size(), usual);
}

}  // namespace

std::vector<MovingTag> MotionOf(std::span<const TagInPicture> tags) {
  std::map<std::tuple<int, int, std::int64_t>, const TagInPicture*> at;
  std::set<std::int64_t> stamps;
  for (const TagInPicture& tag : tags) {
    at[{tag.camera, tag.tag, tag.stamp}] = &tag;
    stamps.insert(tag.stamp);
  }
  std::vector<std::int64_t> steps;
  for (auto next = stamps.begin(); next != stamps.end() && std::next(next) != stamps.end(); ++next)
    steps.push_back(*std::next(next) - *next);
  if (steps.empty()) return {};
  const double step = Median(std::move(steps));
  std::vector<MovingTag> moving;
  for (const TagInPicture& tag : tags) {
    const auto here = stamps.find(tag.stamp);
    if (here == stamps.begin() || std::next(here) == stamps.end()) continue;
    const auto before = at.find({tag.camera, tag.tag, *std::prev(here)});
    const auto after = at.find({tag.camera, tag.tag, *std::next(here)});
    if (before == at.end() || after == at.end()) continue;
    const auto between = static_cast<double>(*std::next(here) - *std::prev(here));
    if (between > 2.4 * step) continue;
    MovingTag m{tag, (after->second->corners_px - before->second->corners_px) / between, 0};
    m.px_per_picture = 0.5 * between * m.velocity.colwise().norm().mean();
    moving.push_back(m);
  }
  return moving;
}

std::vector<TagInPicture> UnlinkMoving(std::span<const TagInPicture> tags, double fastest, int most_alone) {
  std::map<std::pair<std::int64_t, int>, std::pair<double, int>> motion;  // of a picture: sum, count
  for (const MovingTag& m : MotionOf(tags)) {
    auto& [sum, count] = motion[{m.seen.stamp, m.seen.camera}];
    sum += m.px_per_picture;
    ++count;
  }
  std::vector<TagInPicture> kept;
  std::map<int, std::vector<Picture>> moving;  // by camera
  for (const Picture& picture : GroupByPicture(tags)) {
    const auto known = motion.find({picture[0]->stamp, picture[0]->camera});
    if (known == motion.end() || known->second.first >= fastest * known->second.second) {
      moving[picture[0]->camera].push_back(picture);
      continue;
    }
    for (const TagInPicture* tag : picture) kept.push_back(*tag);
  }
  std::int64_t stamp = 0;
  for (const auto& [camera, pictures] : moving) {
    const size_t used = std::min(pictures.size(), static_cast<size_t>(std::max(0, most_alone)));
    for (size_t i = 0; i < used; ++i) {
      --stamp;
      for (const TagInPicture* tag : pictures[i * pictures.size() / used]) {
        kept.push_back(*tag);
        kept.back().stamp = stamp;
      }
    }
  }
  return kept;
}

std::vector<BoardView> ViewsOfTags(std::span<const TagInPicture> tags) {
  std::vector<BoardView> views;
  for (const TagInPicture& tag : tags)
    views.push_back({tag.stamp, tag.tag, tag.camera, {{0, 1, 2, 3}, tag.corners_px}});
  return views;
}

Result<TagBody> FindTagBody(const std::vector<Camera>& lenses, std::span<const TagInPicture> tags,
                            const TagBodyOptions& options) {
  if (!(options.border > 0)) {
    return Error{ErrorKind::kBadInput,
                 fmt::format("the tags' border is {} m; expected more than 0", options.border)};
  }
  for (const TagInPicture& tag : tags) {
    if (tag.camera >= 0 && static_cast<size_t>(tag.camera) < lenses.size()) continue;
    return Error{ErrorKind::kBadInput, fmt::format("tag {} in a picture of camera {}; expected 0 to {}",
                                                   tag.tag, tag.camera, static_cast<int>(lenses.size()) - 1)};
  }
  std::vector<Picture> pictures = GroupByPicture(tags);
  std::erase_if(pictures, [](const Picture& p) { return p.size() < 2; });
  if (pictures.empty()) {
    return Error{ErrorKind::kUnreachable, "no picture shows two tags; expected pictures of several at once"};
  }
  LinkedTags linked;
  for (const Picture& picture : pictures) linked.Add(picture);
  if (const std::vector<int> apart = linked.Apart(); !apart.empty()) {
    return Error{ErrorKind::kUnreachable,
                 fmt::format("no chain of pictures links tags {} to the others; expected pictures that show "
                             "one of each at once",
                             fmt::join(apart, ", "))};
  }
  pictures = Choose(std::move(pictures), options.most_pictures);

  // Roles change: a picture is a camera, a tag a board that all of them see at once.
  std::vector<Camera> cameras;
  std::vector<BoardView> views;
  for (const Picture& picture : pictures) {
    for (const TagInPicture* tag : picture)
      views.push_back({tag->tag, 0, static_cast<int>(cameras.size()), {{0, 1, 2, 3}, tag->corners_px}});
    cameras.push_back(lenses[static_cast<size_t>(picture[0]->camera)]);
    cameras.back().camera_from_lab.setIdentity();
  }
  const Eigen::Matrix3Xd corners = TagCorners3d(options.border);
  auto started = StartRig(std::move(cameras), views, corners);
  if (!started.ok()) {
    return Error{ErrorKind::kUnreachable,
                 "the tags' places do not follow from the pictures: " + started.error().message};
  }
  Bundle& bundle = started.value().bundle;
  constexpr int kRounds = 3;
  for (int round = 0; round < kRounds; ++round) {
    const auto fit = AdjustBundle(bundle, {.fit_intrinsics = false});
    if (!fit.ok()) return fit.error();
    if (round + 1 < kRounds) WeighPictures(bundle);
  }
  TagBody body;
  body.rms_px = RmsOf(bundle).all_px;
  body.pictures = static_cast<int>(pictures.size());
  body.points.resize(3, 4 * static_cast<Eigen::Index>(bundle.places.size()));
  const Eigen::Isometry3d body_from_lab = bundle.places[0].lab_from_board.inverse();
  for (size_t i = 0; i < bundle.places.size(); ++i) {  // by stamp, here the tag's id
    body.tags.push_back(static_cast<int>(bundle.places[i].stamp));
    body.points.middleCols<4>(4 * static_cast<Eigen::Index>(i)) =
        body_from_lab * bundle.places[i].lab_from_board * corners;
  }
  return body;
}

std::vector<BoardView> ViewsOfBody(const TagBody& body, std::span<const TagInPicture> tags) {
  std::vector<BoardView> views;
  for (const Picture& picture : GroupByPicture(tags)) {
    BoardView view{picture[0]->stamp, 0, picture[0]->camera, {}};
    view.corners.pixels.resize(2, 4 * static_cast<Eigen::Index>(picture.size()));
    Eigen::Index corners = 0;
    for (const TagInPicture* tag : picture) {
      const auto known = std::lower_bound(body.tags.begin(), body.tags.end(), tag->tag);
      if (known == body.tags.end() || *known != tag->tag) continue;
      for (int k = 0; k < 4; ++k)
        view.corners.ids.push_back(4 * static_cast<int>(known - body.tags.begin()) + k);
      view.corners.pixels.middleCols<4>(corners) = tag->corners_px;
      corners += 4;
    }
    if (corners == 0) continue;
    view.corners.pixels.conservativeResize(Eigen::NoChange, corners);
    views.push_back(std::move(view));
  }
  return views;
}

}  // namespace tendril
