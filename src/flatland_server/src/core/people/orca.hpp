#pragma once

/// Optimal reciprocal collision avoidance (ORCA): a velocity near the preferred one that collides
/// with nothing within a time.
///
/// J. van den Berg, S. J. Guy, M. Lin and D. Manocha, "Reciprocal n-body collision avoidance",
/// Robotics Research, 2011. Each neighbour forbids the velocities that lead to a collision with it:
/// a truncated cone. The least change of the relative velocity that leaves the cone is shared with
/// the neighbour; what remains for the agent is a half plane of permitted velocities. A linear
/// programme in two dimensions finds the velocity in all half planes that is nearest to the
/// preferred one; if there is none, a programme in three dimensions finds the velocity that
/// violates the half planes least.

#include <cstddef>
#include <vector>

#include "base/geometry.hpp"
#include "people/social_force.hpp"

namespace flatland {

/// The velocities on the left of a line, and on it.
struct HalfPlane {
  Vec2 point;      ///< of the line [m/s]
  Vec2 direction;  ///< of length 1
};

/// A moving disc that is avoided.
struct OrcaNeighbor {
  Vec2 offset;          ///< from the agent [m]
  Vec2 velocity;        ///< [m/s]
  double radius = 0.0;  ///< its own and the agent's [m]
  double share = 0.5;   ///< of the change of the relative velocity that the agent makes
};

struct OrcaSettings {
  double horizon = 2.0;       ///< time without collisions with neighbours [s]
  double wall_horizon = 1.0;  ///< with walls and what stays [s]
  double distance = 5.0;      ///< up to which neighbours count [m]
  int neighbors = 10;         ///< the nearest of them that count

  /// Throws std::invalid_argument if a number is not finite, or not above zero.
  void Require() const;
};

/// The half plane of a neighbour, for an agent with a velocity [m/s]. If the two overlap, they must
/// be apart after `dt` [s].
HalfPlane AvoidNeighbor(const OrcaNeighbor& other, Vec2 velocity, double horizon, double dt);
/// The half plane of the nearest point of a wall, at a gap without the agent's radius: the agent
/// may approach it only so fast that the gap lasts for the horizon [s].
HalfPlane AvoidWall(const Obstacle& wall, double horizon);
/// The velocity in all half planes, at most `most` [m/s] long, that is nearest to the preferred
/// one. The first `walls` half planes are kept to even if others cannot be.
Vec2 ChooseVelocity(const std::vector<HalfPlane>& planes, size_t walls, Vec2 preferred,
                    double most);

}  // namespace flatland
