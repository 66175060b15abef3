/// Crowd: the velocities that people choose, where they go, and what they notice.

#include <algorithm>
#include <cmath>

#include "base/to_box2d.hpp"
#include "people/crowd.hpp"
#include "people/obstacles.hpp"
#include "world/layers.hpp"

namespace flatland {
namespace {

constexpr double kMostSpeed =
    1.3;  // over desired speed (Helbing and Molnar, Phys. Rev. E 51, 1995)
constexpr double kEncounter = 5.0;  // from a robot, at which an encounter begins [m]
constexpr int kTries = 100;         // to draw a free point
constexpr double kWallRoom = 0.1;   // of drawn points, beside a person's radius [m]
constexpr double kOthersRoom = 0.5;
constexpr double kTolerance =
    1e-5;  // of the room of a person: positions are in single precision [m]

// The forces within groups, see GroupForce [m/s^2]; their vision is that of both eyes.
constexpr double kGaze = 4.0, kAttraction = 3.0, kGroupRepulsion = 1.0;
constexpr double kVision = M_PI / 2.0;   // on either side [rad]
constexpr double kGroupGap = 0.3;        // below which members of a group repel each other [m]
constexpr double kStandingStill = 0.05;  // a robot that is slower stands [m/s]

}  // namespace

// ---- Goals ----

template <class IsFree>
std::optional<Vec2> Crowd::DrawPoint(size_t index, const Layers& layers, IsFree is_free) {
  const PersonSettings& person = people_[index];
  const Area& area = *person.area;
  const double room = person.radius + kWallRoom;
  for (int i = 0; i < kTries; ++i) {
    const double x = clock_.numbers.DrawUniform(), y = clock_.numbers.DrawUniform();
    const Vec2 point{area.low.x + x * (area.high.x - area.low.x),
                     area.low.y + y * (area.high.y - area.low.y)};
    SeeWalls(layers, settings_.layers, point, room, found_, walls_);
    if (walls_.empty() && is_free(point)) return point;
  }
  return std::nullopt;
}

Vec2 Crowd::DesiredDirection(size_t index, const Layers& layers) {
  const PersonSettings& person = people_[index];
  const Vec2 point = motions_[index].point;
  Progress& progress = progress_[index];
  const auto is_at = [&](Vec2 goal) { return LengthOf(goal - point) <= settings_.goal_radius; };
  bool ends = person.goals.size() == 1;
  Vec2 goal;
  if (person.area) {
    ends = person.stands;
    if (!progress.has_drawn || (!person.stands && is_at(progress.drawn_goal))) {
      progress.has_drawn = true;
      progress.drawn_goal =
          person.stands ? point
                        : DrawPoint(index, layers, [](Vec2) { return true; }).value_or(point);
    }
    goal = progress.drawn_goal;
  } else {
    if (is_at(person.goals[progress.goal])) {
      progress.goal = progress.goal + 1 < person.goals.size() ? progress.goal + 1 : 0;
    }
    goal = person.goals[progress.goal];
  }
  const Vec2 left = goal - point;
  // With a single goal, slows down when it would arrive in less than twice the relaxation time.
  const double slow_down = ends ? person.speed * 2.0 * settings_.force.relaxation_time : 1e-9;
  return (1.0 / std::max(LengthOf(left), slow_down)) * left;
}

bool Crowd::Scatter(Bodies& bodies, const Layers& layers) {
  // Scattering must not use up random numbers of the walk: a batch seeds those anew when a world is
  // loaded.
  const NormalNumbers of_walk = clock_.numbers;
  const double seed = clock_.numbers.DrawUniform();
  clock_.numbers = NormalNumbers(NormalNumbers::Mixed(static_cast<uint64_t>(seed * 0x1p53)));
  FindOthers(bodies);
  bool found_all = true;
  std::vector<std::pair<Vec2, double>> taken;  // points and radii of people
  for (size_t i = 0; i < people_.size(); ++i) {
    if (people_[i].recording) Replay(i, bodies);
    if (people_[i].area) continue;
    const b2Vec2 point = bodies.Get(people_[i].body).body->GetPosition();
    taken.push_back({FromBox2D(point), people_[i].radius});
  }
  for (size_t i = 0; i < people_.size(); ++i) {
    const PersonSettings& person = people_[i];
    if (!person.area) continue;
    const auto is_free = [&](Vec2 point) {
      const bool is_crowded = std::any_of(taken.begin(), taken.end(), [&](const auto& other) {
        return LengthOf(point - other.first) < other.second + person.radius + kWallRoom;
      });
      return !is_crowded && std::none_of(others_.begin(), others_.end(), [&](const Outline& each) {
        const b2Body& body = *each.body;
        const Vec2 at = FromBox2D(body.GetPosition());
        return each.SeenFrom(point, at, Rotation(body.GetAngle())).gap - person.radius <
               kOthersRoom;
      });
    };
    const std::optional<Vec2> point = DrawPoint(i, layers, is_free);
    if (!point) found_all = false;
    if (!point) continue;
    taken.push_back({*point, person.radius});
    JumpTo(person, *point, bodies);
    progress_[i].has_drawn = person.stands;
    progress_[i].drawn_goal = *point;
  }
  clock_.numbers = of_walk;
  if (found_all) return true;
  const std::vector<Clearances> clearances = GetClearances(bodies, layers);
  for (size_t i = 0; i < people_.size(); ++i) {
    const double least = std::min({clearances[i].wall, clearances[i].body, clearances[i].person});
    if (people_[i].area && least < people_[i].radius - kTolerance) return false;
  }
  return true;
}

// ---- Attention ----

bool Crowd::Sees(size_t index, Vec2 direction) const {
  const double view = people_[index].field_of_view;
  if (view >= 2.0 * M_PI) return true;
  const Vec2 heading = Rotation(motions_[index].yaw).Apply({1.0, 0.0});
  return std::abs(std::atan2(Cross(heading, direction), Dot(heading, direction))) <= view / 2.0;
}

Obstacle Crowd::SeenOther(size_t index, size_t other) const {
  Obstacle seen = others_[other].SeenFrom(motions_[index].point, motions_of_others_[other].point,
                                          headings_of_others_[other]);
  seen.gap -= people_[index].radius;
  return seen;
}

bool Crowd::Avoids(size_t index, size_t other) const {
  if (!others_[other].is_robot) return true;
  if (!people_[index].sees_robots) return false;
  return gives_way_[index] || LengthOf(motions_of_others_[other].velocity) < kStandingStill;
}

/// An encounter lasts as long as a robot is near: it begins with the draw, and the reaction time
/// passes while a robot is seen.
void Crowd::UpdateEncounters(double dt) {
  gives_way_.assign(people_.size(), 1);
  for (size_t i = 0; i < people_.size(); ++i) {
    const PersonSettings& person = people_[i];
    if (person.yields >= 1.0 && person.reaction_time <= 0.0) continue;
    gives_way_[i] = 0;
    if (!person.sees_robots || person.yields <= 0.0) continue;
    bool is_near = false, is_seen = false;
    for (size_t k = 0; k < others_.size(); ++k) {
      if (!others_[k].is_robot) continue;
      const Obstacle robot = SeenOther(i, k);
      if (robot.gap > kEncounter) continue;
      is_near = true;
      is_seen = is_seen || Sees(i, -1.0 * robot.away);
    }
    Progress& progress = progress_[i];
    if (is_near && !progress.has_met) {
      progress.gives_way = person.yields >= 1.0 || clock_.numbers.DrawUniform() < person.yields;
      progress.seen_for = 0.0;
    }
    progress.has_met = is_near;
    gives_way_[i] = is_near && progress.gives_way && progress.seen_for >= person.reaction_time;
    if (is_seen) progress.seen_for = std::min(progress.seen_for + dt, 1e6);
  }
}

// ---- Social force ----

/// Two people avoid each other with opposite accelerations: gap, direction and relative velocity
/// are the same for both except for their signs, and the signs of the forces follow.
void Crowd::SumForces(const Layers& layers) {
  const SocialForce& force = settings_.force;
  forces_.assign(people_.size(), {});
  walkers_.Resize(people_.size());
  for (size_t i = 0; i < people_.size(); ++i) {
    walkers_.Set(i, motions_[i].point, motions_[i].velocity, people_[i].radius);
  }
  for (size_t i = 0; i < people_.size(); ++i) {
    const Motion& own = motions_[i];
    const double radius = people_[i].radius;
    Forces& sum = forces_[i];
    force.FindNear(walkers_, i, near_walkers_);
    for (const uint32_t j : near_walkers_) {
      const Vec2 away = own.point - motions_[j].point;
      const double distance = LengthOf(away);
      const Obstacle other{distance - radius - people_[j].radius,
                           distance > 0.0 ? (1.0 / distance) * away : away};
      const Vec2 push = force.Repel(other);
      const Vec2 evasion = force.Evade(other, own.velocity - motions_[j].velocity);
      if (Sees(i, -1.0 * other.away)) {
        sum.repulsion = sum.repulsion + push;
        sum.evasion = sum.evasion + evasion;
      }
      if (Sees(j, other.away)) {
        forces_[j].repulsion = forces_[j].repulsion - push;
        forces_[j].evasion = forces_[j].evasion - evasion;
      }
    }
    for (size_t k = 0; k < others_.size(); ++k) {
      if (!Avoids(i, k)) continue;
      const Obstacle seen = SeenOther(i, k);
      if (others_[k].is_robot && !Sees(i, -1.0 * seen.away)) continue;
      sum.repulsion = sum.repulsion + force.Repel(seen);
      sum.evasion = sum.evasion + force.Evade(seen, own.velocity - motions_of_others_[k].velocity);
    }
    SeeWalls(layers, settings_.layers, own.point, ReachOf(people_[i]), found_, walls_);
    for (Obstacle& wall : walls_) {
      wall.gap -= radius;
      sum.repulsion = sum.repulsion + force.Repel(wall);
    }
  }
}

/// M. Moussaid, N. Perozo, S. Garnier, D. Helbing and G. Theraulaz, "The walking behaviour of
/// pedestrian social groups and its impact on crowd dynamics", PLoS ONE 5(4), 2010: slows down by
/// the angle that the head has to be turned to see the others' middle, is drawn to the middle of
/// the group from beyond (n - 1) / 2 metres, and away from members who are close.
Vec2 Crowd::GroupForce(size_t index) const {
  const int group = people_[index].group;
  const Motion& own = motions_[index];
  Vec2 sum, push;
  int others = 0;
  for (size_t j = 0; j < people_.size(); ++j) {
    if (j == index || people_[j].group != group) continue;
    const Vec2 away = own.point - motions_[j].point;
    const double distance = LengthOf(away);
    sum = sum + motions_[j].point;
    ++others;
    const bool is_close = distance - people_[index].radius - people_[j].radius < kGroupGap;
    if (is_close && distance > 0.0) push = push + (kGroupRepulsion / distance) * away;
  }
  if (others == 0) return {};
  Vec2 force = push;
  const Vec2 to_others = (1.0 / others) * sum - own.point;
  const double angle =
      std::abs(std::atan2(Cross(own.velocity, to_others), Dot(own.velocity, to_others)));
  if (angle > kVision) force = force - kGaze * (angle - kVision) * own.velocity;
  const Vec2 to_middle = (1.0 / (others + 1)) * (sum + own.point) - own.point;
  const double distance = LengthOf(to_middle);
  if (distance > others / 2.0) force = force + (kAttraction / distance) * to_middle;
  return force;
}

Vec2 Crowd::ForcedVelocity(size_t index, Vec2 way, Vec2 noise, double left) {
  const SocialForce& force = settings_.force;
  const double desired = people_[index].speed;
  const double will = LengthOf(way);  // a person that stands neither evades nor sways
  Vec2 evasion = forces_[index].evasion;
  if (people_[index].group >= 0) evasion = evasion + GroupForce(index);
  const Vec2 acceleration = forces_[index].repulsion + will * evasion;
  const Vec2 velocity =
      force.Relax(motions_[index].velocity, desired * way, acceleration, left) + will * noise;
  const double speed = LengthOf(velocity), most = kMostSpeed * desired;
  return speed > most ? (most / speed) * velocity : velocity;
}

// ---- ORCA ----

void Crowd::SortByX() {
  by_x_.resize(people_.size());
  rank_.resize(people_.size());
  for (uint32_t i = 0; i < by_x_.size(); ++i) by_x_[i] = i;
  std::sort(by_x_.begin(), by_x_.end(), [this](uint32_t a, uint32_t b) {
    const double difference = motions_[a].point.x - motions_[b].point.x;
    return difference != 0.0 ? difference < 0.0 : a < b;
  });
  for (uint32_t i = 0; i < by_x_.size(); ++i) rank_[by_x_[i]] = i;
}

/// People are sorted by x: only those within a strip are looked at.
void Crowd::FindNeighbors(size_t index) {
  const Motion& own = motions_[index];
  const double reach = settings_.orca->distance;
  near_.clear();
  const auto look_at = [&](uint32_t j) {
    const Vec2 offset = motions_[j].point - own.point;
    if (std::abs(offset.x) > reach) return false;
    const double square = Dot(offset, offset);
    if (square <= reach * reach && Sees(index, offset)) near_.emplace_back(square, j);
    return true;
  };
  for (uint32_t rank = rank_[index] + 1; rank < by_x_.size() && look_at(by_x_[rank]);) ++rank;
  for (uint32_t rank = rank_[index]; rank > 0 && look_at(by_x_[rank - 1]);) --rank;
  const size_t count = std::min(near_.size(), static_cast<size_t>(settings_.orca->neighbors));
  std::partial_sort(near_.begin(), near_.begin() + static_cast<std::ptrdiff_t>(count), near_.end());
  near_.resize(count);
  neighbors_.clear();
  for (const auto& [square, j] : near_) {
    neighbors_.push_back({motions_[j].point - own.point, motions_[j].velocity,
                          people_[index].radius + people_[j].radius, 0.5});
  }
}

/// Robots count as discs through their nearest point. People expect robots to do nothing, and make
/// the whole change of velocity themselves.
Vec2 Crowd::OrcaVelocity(size_t index, Vec2 way, Vec2 noise, const Layers& layers, double dt) {
  const OrcaSettings& orca = *settings_.orca;
  const PersonSettings& person = people_[index];
  const Motion& own = motions_[index];
  const double most = kMostSpeed * person.speed;
  planes_.clear();
  SeeWalls(layers, settings_.layers, own.point, person.radius + most * orca.wall_horizon, found_,
           walls_);
  for (Obstacle& wall : walls_) {
    wall.gap -= person.radius;
    planes_.push_back(AvoidWall(wall, orca.wall_horizon));
  }
  FindNeighbors(index);
  for (size_t k = 0; k < others_.size(); ++k) {
    const Outline& other = others_[k];
    if (!Avoids(index, k)) continue;
    const Obstacle seen = SeenOther(index, k);
    if (seen.gap > orca.distance || (other.is_robot && !Sees(index, -1.0 * seen.away))) continue;
    if (other.body->GetType() == b2_staticBody) {
      planes_.push_back(AvoidWall(seen, orca.wall_horizon));
      continue;
    }
    const double distance = seen.gap + person.radius;
    const Vec2 nearest = own.point - distance * seen.away;
    const double radius = LengthOf(nearest - motions_of_others_[k].point);
    neighbors_.push_back({-(distance + radius) * seen.away, motions_of_others_[k].velocity,
                          person.radius + radius, 1.0});
  }
  const size_t walls = planes_.size();
  for (const OrcaNeighbor& each : neighbors_) {
    planes_.push_back(AvoidNeighbor(each, own.velocity, orca.horizon, dt));
  }
  Vec2 preferred = person.speed * way + LengthOf(way) * noise;
  if (person.group >= 0) preferred = preferred + dt * GroupForce(index);
  return ChooseVelocity(planes_, walls, preferred, most);
}

}  // namespace flatland
