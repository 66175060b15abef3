#pragma once

/// The social force model: how people speed up, slow down and give way.
///
/// A person of velocity v accelerates by
///
///     dv/dt = (v0 e - v) / tau  +  sum of  A exp(-gap / B) n  +  sum of evasions
///
/// with the desired speed v0 in the desired direction e, and n away from another person, from a
/// robot, or from the nearest point of a wall. That is equations 1 to 3 of Helbing, Farkas and
/// Vicsek, "Simulating dynamical features of escape panic", Nature 407, 2000, with its constants.
/// Its gap, d - r1 - r2 between two discs and d - r to a wall, takes the sizes of bodies into
/// account; its terms for bodies that touch are left to Box2D.
///
/// These forces do not look ahead. Their evasions are those of Moussaid, Helbing, Garnier,
/// Johansson, Combe and Theraulaz, "Experimental study of the behavioural mechanisms underlying
/// self-organization in human crowds", Proc. R. Soc. B 276, 2009, with the constants that were
/// measured there: people turn away in time, to a preferred side, and slow down a little. Here too,
/// distances are gaps. A force counts as none beyond 8 of its ranges.

#include <cmath>
#include <cstdint>
#include <vector>

#include "base/geometry.hpp"

namespace flatland {

/// Something that people avoid: its gap [m], and the direction away from it, of length 1 or 0.
struct Obstacle {
  double gap = 0.0;
  Vec2 away;
};

/// People as a structure of arrays, so that several are computed at a time. The arrays are padded
/// behind the last person; the padding does not matter.
struct Walkers {
  void Resize(size_t count);
  void Set(size_t index, Vec2 point, Vec2 velocity, double radius);

  size_t count = 0;
  std::vector<double> x, y;    ///< [m]
  std::vector<double> vx, vy;  ///< [m/s]
  std::vector<double> radius;  ///< [m]
};

/// The constants; by default those of the papers, for 80 kg.
struct SocialForce {
  double relaxation_time = 0.5;  ///< tau: a deviation from the desired velocity falls to 1/e [s]
  double repulsion = 2000.0 / 80.0;  ///< A over the mass: acceleration on contact [m/s^2]
  double range = 0.08;               ///< B: over which the repulsion falls to 1/e [m]
  double evasion = 4.5;              ///< A of the evasions [m/s^2]
  double side_preference = 0.005;  ///< epsilon: evades to the right; negative: to the left [rad/m]
  double noise = 0.05;  ///< standard deviation of a walking person's velocity on each axis [m/s]

  /// Throws std::invalid_argument if a constant is not finite, or has a value that makes no sense.
  void Require() const;
  /// The acceleration away from an obstacle [m/s^2]. Overlap counts as touching: separating
  /// overlapping bodies is left to Box2D.
  Vec2 Repel(const Obstacle& obstacle) const;
  /// The acceleration of a person that evades another [m/s^2].
  ///
  /// Another person in the direction e, at the relative velocity w, is met on the course t of
  /// D = lambda w + e. With the angle theta from t to e, t turned left l, and b = gamma |D|,
  ///
  ///     f = -A exp(-gap / b) (exp(-(n' b theta)^2) t + sign(theta) exp(-(n b theta)^2) l)
  ///
  /// where the preference epsilon b is added to theta beforehand. `velocity` is the person's own
  /// less that of the other [m/s].
  Vec2 Evade(const Obstacle& other, Vec2 velocity) const;
  /// Finds the indices above `index`, in ascending order, of those near enough for forces on that
  /// person or from it. For all others, Repel and Evade are zero.
  void FindNear(const Walkers& people, size_t index, std::vector<uint32_t>& near) const;
  /// The part of a deviation from the desired velocity that is left after `dt` [s].
  double LeftAfter(double dt) const;
  /// The velocity [m/s] after `dt` [s] of the driving force and a constant acceleration: the exact
  /// solution of dv/dt = (desired - v) / tau + acceleration. `left` is LeftAfter(dt).
  Vec2 Relax(Vec2 velocity, Vec2 desired, Vec2 acceleration, double left) const;
  /// The standard deviation [m/s] of the random change of a velocity after `dt` [s] of Relax. It
  /// keeps the deviation of velocities at `noise` for any `dt`: they are an Ornstein-Uhlenbeck
  /// process.
  double ScatterAfter(double dt) const;
};

}  // namespace flatland
