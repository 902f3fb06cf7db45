// The focal lengths that nobody knows, from the two views of all photos together.
#ifndef CAIRN_MAPPING_MATCHING_CALIBRATE_GUESSES_H_
#define CAIRN_MAPPING_MATCHING_CALIBRATE_GUESSES_H_

#include <span>
#include <utility>
#include <vector>

#include "mapping/matching/two_view.h"
#include "mapping/photo_set.h"

namespace cairn {

// True if the focal length of a camera of the set is a guess.
bool HasGuesses(const PhotoSet& set);

// The pairs whose two views CalibrateGuesses needs, in the order of `pairs`: those of photos whose
// focal length is a guess, for each camera at most as many as improve the estimate.
std::vector<std::pair<int, int>> PairsForCalibration(const PhotoSet& set,
                                                     std::span<const std::pair<int, int>> pairs);

// Returns the cameras of the set; where the source was kGuess and the two views tell the focal
// length, it has that focal length, the source kPhotos, and the standard deviation found.
//
// A pair alone tells little: a longer lens on one side resembles a shorter one on the other, and a
// wall leaves both open. So each pair states how badly its inliers fit under each pair of focal
// lengths of a grid (the whole range of lenses), and those of all cameras are chosen that
// fit all pairs together. docs/math/mapping.md has the formulas. Deterministic; the result does not
// depend on the number of threads.
std::vector<MappingCamera> CalibrateGuesses(const PhotoSet& set, std::span<const TwoView> views,
                                            int num_threads);

}  // namespace cairn

#endif  // CAIRN_MAPPING_MATCHING_CALIBRATE_GUESSES_H_
