// Turns the residuals of a discarded camera into a prior on the other cameras.
#ifndef CAIRN_LAB_RIVALS_FUSION_MARGINALIZE_CAMERA_H_
#define CAIRN_LAB_RIVALS_FUSION_MARGINALIZE_CAMERA_H_

#include <optional>
#include <span>

#include "lab/rivals/fusion/bundle_adjuster_options.h"
#include "lab/rivals/fusion/marginal_prior.h"
#include "lab/rivals/fusion/window_tracks.h"
#include "lab/rivals/fusion/window_variables.h"

namespace cairn::fusion {

// Marginalizes the first of `cameras` (at least 3, ordered by time). The residuals that become the
// prior are: the old prior, the camera's inertial residual, its observations of map landmarks, and
// local tracks that the camera saw and that have ended or are seen by every camera.
//
// Each of these local tracks contributes all its observations except that of the newest camera. Its
// landmark is eliminated, and the used observations are dropped afterwards. Every other local track
// loses only the marginalized camera's observation. `alignment` may be null.
MarginalPrior MarginalizeCamera(const BundleAdjusterOptions& options,
                                std::span<WindowCamera* const> cameras, WindowAlignment* alignment,
                                const std::optional<MarginalPrior>& prior, WindowTracks* tracks);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_MARGINALIZE_CAMERA_H_
