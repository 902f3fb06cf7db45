// Levenberg and Marquardt's iterations, for the small dense problems of poses, cameras and points.
#ifndef CAIRN_CORE_LEAST_SQUARES_H_
#define CAIRN_CORE_LEAST_SQUARES_H_

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <limits>
#include <optional>
#include <utility>

namespace cairn {

// A cost below which nothing is worth a step, in squared standard deviations or pixels. Rays that
// meet exactly have a cost of zero, which no share of it can end.
inline constexpr double kNegligibleCost = 1e-8;

// The normal equations of a problem with N parameters at one state.
template <int N>
struct NormalSystem {
  Eigen::Matrix<double, N, N> normal = Eigen::Matrix<double, N, N>::Zero();    // Sum of w J'J.
  Eigen::Matrix<double, N, 1> gradient = Eigen::Matrix<double, N, 1>::Zero();  // Sum of w J'r.
  double cost = 0.0;  // In any unit; only ratios and differences count.
};

struct MinimizeOptions {
  int max_steps = 20;  // Tried steps, whether they lower the cost or not.
  // The damping is relative to the diagonal of the normal matrix. A step that lowers the cost
  // divides it by ten, at most to `min_damping`. Another one raises it to at least
  // `min_damping_after_failure` and multiplies it by ten. The iterations end at `max_damping`.
  double initial_damping = 1e-4;
  double min_damping = 0.0;
  double min_damping_after_failure = 0.0;
  double max_damping = 1e6;
  // Added to the diagonal, so that a parameter without observations stays where it is.
  double diagonal_floor = 0.0;
  // The iterations have converged after a step that lowers the cost by a smaller share of it ...
  double min_decrease = 0.0;
  // ... or before a step that by the normal equations would.
  double min_predicted_decrease = 0.0;
};

template <int N, typename State>
struct Minimum {
  State state;
  NormalSystem<N> system;  // At `state`.
  int num_steps = 0;       // Steps that lowered the cost.
  bool has_converged = false;
};

// Minimizes from `state`. linearize(state) returns std::optional<NormalSystem<N>>, empty where the
// problem is not defined, for example behind a camera; such a step counts as one that does not
// lower the cost. move(state, step) returns the state after a step. Returns nothing if the problem
// is not defined at `state`.
template <int N, typename State, typename Linearize, typename Move>
std::optional<Minimum<N, State>> MinimizeLeastSquares(State state, const Linearize& linearize,
                                                      const Move& move,
                                                      const MinimizeOptions& options) {
  std::optional<NormalSystem<N>> system = linearize(state);
  if (!system) {
    return std::nullopt;
  }
  Minimum<N, State> minimum{std::move(state), *std::move(system)};
  double damping = options.initial_damping;
  for (int i = 0; damping < options.max_damping; ++i) {
    Eigen::Matrix<double, N, N> damped = minimum.system.normal;
    damped.diagonal() *= 1.0 + damping;
    damped.diagonal().array() += options.diagonal_floor;
    const Eigen::Matrix<double, N, 1> step = -damped.ldlt().solve(minimum.system.gradient);
    minimum.has_converged =
        -step.dot(minimum.system.gradient) <
        options.min_predicted_decrease * (minimum.system.cost + kNegligibleCost);
    if (minimum.has_converged || i == options.max_steps) {
      break;
    }
    State moved = move(minimum.state, step);
    std::optional<NormalSystem<N>> moved_system = linearize(moved);
    if (!moved_system || !(moved_system->cost < minimum.system.cost)) {
      damping = std::max(options.min_damping_after_failure, damping) * 10.0;
      continue;
    }
    const double decrease = minimum.system.cost - moved_system->cost;
    minimum.state = std::move(moved);
    minimum.system = *std::move(moved_system);
    ++minimum.num_steps;
    damping = std::max(options.min_damping, damping * 0.1);
    minimum.has_converged =
        decrease < options.min_decrease * (minimum.system.cost + kNegligibleCost);
    if (minimum.has_converged) {
      break;
    }
  }
  return minimum;
}

}  // namespace cairn

#endif  // CAIRN_CORE_LEAST_SQUARES_H_
