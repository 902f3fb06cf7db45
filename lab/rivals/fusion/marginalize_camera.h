// Turns the residuals that a camera leaves behind into a prior on the others.
#ifndef CAIRN_LAB_RIVALS_FUSION_MARGINALIZE_CAMERA_H_
#define CAIRN_LAB_RIVALS_FUSION_MARGINALIZE_CAMERA_H_

#include <optional>
#include <span>

#include "lab/rivals/fusion/bundle_adjuster_options.h"
#include "lab/rivals/fusion/marginal_prior.h"
#include "lab/rivals/fusion/window_tracks.h"
#include "lab/rivals/fusion/window_variables.h"

namespace cairn::fusion {

// Marginalises the first of `cameras` (at least 3, by time) out of: the prior, its inertial
// residual, its sights of landmarks of the map, and the local tracks it saw that have ended or that
// every camera sees (those whole but for the newest camera, with the landmark eliminated, so that
// they are forgotten afterwards; of the other tracks only its own sight is lost). `alignment` may
// be null.
MarginalPrior MarginalizeCamera(const BundleAdjusterOptions& options,
                                std::span<WindowCamera* const> cameras, WindowAlignment* alignment,
                                const std::optional<MarginalPrior>& prior, WindowTracks* tracks);

}  // namespace cairn::fusion

#endif  // CAIRN_LAB_RIVALS_FUSION_MARGINALIZE_CAMERA_H_
