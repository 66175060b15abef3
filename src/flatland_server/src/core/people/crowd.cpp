#include "people/crowd.hpp"

#include <algorithm>
#include <cmath>

#include "base/box2d_limits.hpp"
#include "base/to_box2d.hpp"
#include "people/obstacles.hpp"
#include "world/layers.hpp"

namespace flatland {
namespace {

constexpr double kReach = 8.0;           // of walls, in ranges of the repulsion: it is down to e^-8
constexpr double kTurnRate = M_PI;       // at most [rad/s]
constexpr double kLeastSpeed = 0.1;      // people that are slower keep their heading [m/s]
constexpr double kAgentTimeout = 1.0;    // an agent walks on for this time after its last state [s]
constexpr double kJumpDistance = 1.0;    // a person jumps to an agent that is farther away [m]
constexpr double kLongestPeriod = 1e18;  // 32 years [ns]
constexpr int64_t kLastTime = int64_t{1} << 62;  // [ns]
constexpr int64_t kLookahead = 1'000'000'000;    // look-ahead for the first heading of a walk [ns]
constexpr double kAwayGap = 4.0;                 // between people who are away [m]
constexpr double kSides[] = {1.0, -1.0};         // of the legs: 1 is the left

Vec2 PointOf(const Pose& pose) { return {pose.x, pose.y}; }

/// True for the body of a person, and for those that go along with it.
bool Has(const PersonSettings& person, Bodies::Body body) {
  return person.body == body || person.circle == body ||
         std::find(person.legs.begin(), person.legs.end(), body) != person.legs.end();
}

b2Body& BodyOf(Bodies& bodies, Bodies::Body handle) { return *bodies.Get(handle).body; }

/// Gives a body the velocity that leads to a point [m] in `dt` [s].
void SetVelocityTo(b2Body& body, Vec2 point, double dt) {
  const Vec2 velocity = (1.0 / dt) * (point - FromBox2D(body.GetPosition()));
  SetOriginVelocity(body, {velocity.x, velocity.y, 0.0});
}

/// Moves a body like World::SetPose.
void Put(b2Body& body, const Pose& pose) {
  WakeBodiesNear(body);
  Place(body, pose);
  WakeBodiesNear(body);
  body.SetAwake(true);
}

}  // namespace

Crowd::Crowd() = default;
Crowd::~Crowd() = default;
Crowd::Crowd(const Crowd&) = default;
Crowd& Crowd::operator=(const Crowd&) = default;

Crowd::Crowd(const CrowdSettings& settings, uint64_t key) : settings_(settings) {
  settings.force.Require();
  if (settings.orca) settings.orca->Require();
  Require(settings.period >= 0.0, "a period must not be negative");
  Require(IsUsable(settings.goal_radius) && settings.goal_radius > 0.0,
          "a radius must be above zero");
  Require(settings.begin >= 0.0 && settings.begin < kLongestPeriod, "a begin must be a time");
  clock_.begin = std::llround(settings.begin);
  settings_.period = std::min(settings.period, kLongestPeriod);
  Seed(key);
}

void Crowd::Add(const PersonSettings& person) {
  Require(!person.goals.empty(), "a person needs a goal");
  for (const Vec2& goal : person.goals) {
    Require(std::isfinite(goal.x) && std::isfinite(goal.y), "a goal must be finite");
  }
  Require(person.yields <= 1.0, "a probability must not be above one");
  if (person.area) {
    Require(IsUsable(person.area->low) && IsUsable(person.area->high), "an area must be finite");
    Require(person.area->low.x <= person.area->high.x && person.area->low.y <= person.area->high.y,
            "an area must begin at its lower corner");
  }
  Require(person.legs.empty() || person.legs.size() == 2, "a person has two legs or none");
  for (const double each :
       {person.radius, person.speed, person.leg_offset, person.walk_ratio, person.leg_radius,
        person.swing_radius, person.yields, person.reaction_time, person.field_of_view}) {
    RequireNotNegative(each, "a person's numbers must be finite and not negative");
  }
  people_.push_back(person);
  progress_.emplace_back();
  others_revision_ = 0;
}

void Crowd::RemoveBody(Bodies::Body body) {
  const auto gone = std::find_if(people_.begin(), people_.end(),
                                 [&](const auto& person) { return Has(person, body); });
  if (gone == people_.end()) return;
  progress_.erase(progress_.begin() + (gone - people_.begin()));
  people_.erase(gone);
}

void Crowd::Follow(size_t person, Vec2 point, Vec2 velocity) {
  RequirePosition(point);
  RequirePosition(velocity);
  Require(person < people_.size(), "there is no such person");
  progress_[person].agent = {true, point, velocity, 0.0};
}

bool Crowd::IsValid() const {
  if (clock_.now < 0 || clock_.now > kLastTime) return false;
  if (clock_.begin < 0 || clock_.begin > kLastTime / 2) return false;
  for (size_t i = 0; i < people_.size(); ++i) {
    if (progress_[i].goal >= people_[i].goals.size()) return false;
    const Recording* recording = people_[i].recording.get();
    const int32_t walks = recording ? static_cast<int32_t>(recording->walks.size()) : 0;
    if (progress_[i].walk < -1 || progress_[i].walk >= walks) return false;
    const Agent& agent = progress_[i].agent;
    if (LengthOf(agent.point) > 4.0 * kMaxCoordinate) return false;
    if (!IsUsable(progress_[i].drawn_goal) || !IsUsable(progress_[i].seen_for)) return false;
  }
  return true;
}

// ---- Updates ----

void Crowd::BeginStep(Bodies& bodies, const Layers& layers, double dt) {
  if (clock_.now >= clock_.due) {
    const auto now = static_cast<double>(clock_.now);
    Update(bodies, layers, std::max(settings_.period * 1e-9, dt));
    // As an UpdateTimer that started at time 0.
    if (settings_.period > 0.0) {
      const double passed = std::floor((now + 0.5) / settings_.period) + 1.0;
      clock_.due = static_cast<int64_t>(std::nearbyint(passed * settings_.period));
    }
  }
  clock_.now = std::min(clock_.now + static_cast<int64_t>(std::llround(dt * 1e9)), kLastTime);
}

void Crowd::Update(Bodies& bodies, const Layers& layers, double dt) {
  FindOthers(bodies);
  for (size_t i = 0; i < people_.size(); ++i) {
    if (people_[i].recording) Replay(i, bodies);
  }
  motions_.clear();
  for (const PersonSettings& each : people_)
    motions_.push_back(MotionOf(BodyOf(bodies, each.body)));
  motions_of_others_.clear();
  headings_of_others_.clear();
  for (const Outline& each : others_) {
    motions_of_others_.push_back(MotionOf(*each.body));
    headings_of_others_.emplace_back(motions_of_others_.back().yaw);
  }
  UpdateEncounters(dt);
  const bool do_choose =
      std::any_of(people_.begin(), people_.end(), [](const auto& each) { return !each.recording; });
  if (do_choose && settings_.orca) {
    SortByX();
  } else if (do_choose) {
    SumForces(layers);
  }
  new_velocities_.clear();
  const double scatter = settings_.force.ScatterAfter(dt), left = settings_.force.LeftAfter(dt);
  for (size_t i = 0; i < people_.size(); ++i) {
    const double x = clock_.numbers.Draw(), y = clock_.numbers.Draw();  // drawn even if not needed
    if (people_[i].recording) {
      new_velocities_.push_back(ReplayedVelocity(i, bodies, dt));
      continue;
    }
    if (progress_[i].agent.is_followed) {
      new_velocities_.push_back(FollowingVelocity(i, bodies, dt));
      continue;
    }
    const Vec2 noise{scatter * x, scatter * y}, way = DesiredDirection(i, layers);
    new_velocities_.push_back(settings_.orca ? OrcaVelocity(i, way, noise, layers, dt)
                                             : ForcedVelocity(i, way, noise, left));
  }
  for (size_t i = 0; i < people_.size(); ++i) Walk(i, new_velocities_[i], bodies, dt);
}

void Crowd::FindOthers(const Bodies& bodies) {
  if (others_revision_ == bodies.structure_revision()) return;
  others_ = FindOutlines(bodies, settings_.layers, [this](Bodies::Body body) {
    return std::any_of(people_.begin(), people_.end(),
                       [&](const auto& person) { return Has(person, body); });
  });
  others_revision_ = bodies.structure_revision();
}

Crowd::Motion Crowd::MotionOf(const b2Body& body) {
  const Pose pose = Wrapped(PoseOf(body));
  return {PointOf(pose), pose.yaw, FromBox2D(body.GetLinearVelocityFromLocalPoint(b2Vec2_zero))};
}

double Crowd::ReachOf(const PersonSettings& person) const {
  return person.radius + kReach * settings_.force.range;
}

Vec2 Crowd::FollowingVelocity(size_t index, Bodies& bodies, double dt) {
  const PersonSettings& person = people_[index];
  Agent& agent = progress_[index].agent;
  if (LengthOf(agent.point - motions_[index].point) > kJumpDistance) {
    JumpTo(person, agent.point, bodies);
  }
  if (agent.age < kAgentTimeout) {
    agent.point = agent.point + dt * agent.velocity;
    agent.age += dt;
  }
  const Vec2 here = FromBox2D(BodyOf(bodies, person.body).GetPosition());
  return (1.0 / dt) * (agent.point - here);
}

void Crowd::Replay(size_t index, Bodies& bodies) {
  const PersonSettings& person = people_[index];
  const int64_t now = clock_.begin + clock_.now;
  const int walk = person.recording->WalkAt(now);
  int32_t& shown = progress_[index].walk;
  b2Body& body = BodyOf(bodies, person.body);
  if (walk < 0) {  // a place for each, far away
    const Vec2 away{kAway, kAway + kAwayGap * person.body.index};
    if (shown >= 0 || FromBox2D(body.GetPosition()).x < kAway) JumpTo(person, away, bodies);
  } else {
    const Vec2 point = person.recording->PointAt(walk, now);
    if (walk != shown) {
      const Vec2 way = person.recording->PointAt(walk, now + kLookahead) - point;
      Put(body, {point.x, point.y, std::atan2(way.y, way.x)});
      JumpTo(person, point, bodies);
    } else if (LengthOf(point - FromBox2D(body.GetPosition())) > kJumpDistance) {
      JumpTo(person, point, bodies);
    }
  }
  shown = walk;
}

Vec2 Crowd::ReplayedVelocity(size_t index, Bodies& bodies, double dt) {
  const int walk = progress_[index].walk;
  if (walk < 0) return {};
  const PersonSettings& person = people_[index];
  const int64_t then = clock_.begin + clock_.now + std::llround(dt * 1e9);
  const Vec2 here = FromBox2D(BodyOf(bodies, person.body).GetPosition());
  return (1.0 / dt) * (person.recording->PointAt(walk, then) - here);
}

void Crowd::JumpTo(const PersonSettings& person, Vec2 point, Bodies& bodies) const {
  b2Body& body = BodyOf(bodies, person.body);
  Put(body, {point.x, point.y, body.GetAngle()});
  const Pose pose = PoseOf(body);
  for (size_t i = 0; i < person.legs.size(); ++i) {
    Put(BodyOf(bodies, person.legs[i]), Compose(pose, {0.0, kSides[i] * person.leg_offset, 0.0}));
  }
  if (person.circle) Put(BodyOf(bodies, *person.circle), pose);
}

// ---- Bodies and legs ----

void Crowd::Walk(size_t index, Vec2 velocity, Bodies& bodies, double dt) {
  const PersonSettings& person = people_[index];
  b2Body& body = BodyOf(bodies, person.body);
  const Pose pose = Wrapped(PoseOf(body));
  Twist motion{velocity.x, velocity.y, 0.0};
  if (LengthOf(velocity) > kLeastSpeed) {
    const double turn = WrappedAngle(std::atan2(velocity.y, velocity.x) - pose.yaw);
    motion.omega = std::clamp(turn / dt, -kTurnRate, kTurnRate);
  }
  SetOriginVelocity(body, motion);
  const Pose after{pose.x + velocity.x * dt, pose.y + velocity.y * dt,
                   pose.yaw + motion.omega * dt};
  if (person.circle) SetVelocityTo(BodyOf(bodies, *person.circle), PointOf(after), dt);
  if (!person.legs.empty()) Step(index, after, motion, bodies, dt);
}

/// Steps are sqrt(walk ratio * speed) long. A foot goes from half a step ahead to half a step
/// behind while the body goes on by a step: it stands still on the floor.
void Crowd::Step(size_t index, const Pose& after, const Twist& motion, Bodies& bodies, double dt) {
  const PersonSettings& person = people_[index];
  const Rotation heading(after.yaw);
  const double speed = motion.vx * heading.cos + motion.vy * heading.sin;
  const double length = std::sqrt(person.walk_ratio * std::abs(speed));
  double& stride = progress_[index].stride;
  if (length > 0.0) stride += speed * dt / (2.0 * length);
  stride -= std::floor(stride);
  const double ahead = length / 2.0 * (1.0 - 4.0 * std::abs(stride - 0.5));
  for (size_t i = 0; i < person.legs.size(); ++i) {
    const Vec2 foot{kSides[i] * ahead, kSides[i] * person.leg_offset};
    SetVelocityTo(BodyOf(bodies, person.legs[i]), PointOf(after) + heading.Apply(foot), dt);
  }
  const bool walks = std::hypot(motion.vx, motion.vy) > kLeastSpeed;
  Lift(index, walks ? std::sin(2.0 * M_PI * stride) : 0.0, bodies);
}

/// Sets the radius at which lidars see a leg: thinner in its swing, as above a lifted foot.
void Crowd::Lift(size_t index, double phase, Bodies& bodies) {
  progress_[index].lifted = phase;
  const PersonSettings& person = people_[index];
  if (person.swing_radius == person.leg_radius) return;
  for (size_t i = 0; i < person.legs.size(); ++i) {
    BodyRecord& leg = bodies.Get(person.legs[i]);
    if (leg.fixtures.empty()) continue;
    const double height = std::max(0.0, kSides[i] * phase);
    const double seen = person.leg_radius + (person.swing_radius - person.leg_radius) * height;
    if (leg.fixtures[0].seen_radius == seen) continue;
    leg.fixtures[0].seen_radius = seen;
    bodies.ChangeStructure();
  }
}

void Crowd::Restore(Bodies& bodies) {
  for (size_t i = 0; i < people_.size(); ++i) Lift(i, progress_[i].lifted, bodies);
}

std::vector<Crowd::Clearances> Crowd::GetClearances(const Bodies& bodies, const Layers& layers) {
  FindOthers(bodies);
  std::vector<Vec2> points;
  for (const PersonSettings& each : people_) {
    points.push_back(FromBox2D(bodies.Get(each.body).body->GetPosition()));
  }
  std::vector<Clearances> found;
  for (size_t i = 0; i < people_.size(); ++i) {
    Clearances clearances{HUGE_VAL, HUGE_VAL, HUGE_VAL};
    SeeWalls(layers, settings_.layers, points[i], ReachOf(people_[i]), found_, walls_);
    if (!walls_.empty()) clearances.wall = walls_.front().gap;
    for (const Outline& other : others_) {
      const Pose pose = PoseOf(*other.body);
      const Rotation heading(pose.yaw);
      clearances.body =
          std::min(clearances.body, other.SeenFrom(points[i], PointOf(pose), heading).gap);
    }
    for (size_t j = 0; j < people_.size(); ++j) {
      if (j == i) continue;
      clearances.person =
          std::min(clearances.person, LengthOf(points[i] - points[j]) - people_[j].radius);
    }
    found.push_back(clearances);
  }
  return found;
}

}  // namespace flatland
