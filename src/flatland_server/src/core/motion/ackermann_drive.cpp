#include "motion/ackermann_drive.hpp"

#include <algorithm>
#include <cmath>

#include "base/box2d_limits.hpp"
#include "motion/body_drift.hpp"

namespace flatland {
namespace {

constexpr double kGravity = 9.81;       // [m/s^2], as in CommonRoad
constexpr double kMostYawRate = 100.0;  // [rad/s]
constexpr double kMostParts = 100.0;

/// The lower of two limits; 0 means no limit.
double Lower(double a, double b) { return a > 0.0 && b > 0.0 ? std::min(a, b) : std::max(a, b); }

}  // namespace

AckermannDrive::AckermannDrive(const AckermannSettings& settings,
                               const std::array<b2RevoluteJoint*, 2>& wheels)
    : ActuatedDrive(settings.actuator, true), settings_(settings), wheels_(wheels) {
  settings.linear.Check();
  settings.steering.Check();
  RequireNotNegative(settings.jerk, "a jerk must be finite and not negative");
  Require(IsUsable(settings.wheelbase) && settings.wheelbase >= 1e-3,
          "the front axle must be in front of the rear axle");
  Require(settings.max_steer_angle >= 0.0 && settings.max_steer_angle < M_PI_2,
          "max_steer_angle must be from 0 to less than a right angle");
  if (!settings.single_track) return;
  const SingleTrack& car = *settings.single_track;
  for (double value :
       {car.mass, car.inertia, car.friction, car.front_stiffness, car.rear_stiffness}) {
    Require(IsUsable(value) && value >= 1e-9, "a car's constants must be finite and above zero");
  }
  RequireNotNegative(car.height, "a height must be finite and not negative");
  Require(car.center_of_mass > 0.0 && car.center_of_mass < settings.wheelbase,
          "the centre of mass must be between the axles");
}

void AckermannDrive::Command(const AckermannCommand& command) {
  Require(IsUsable(command.speed) && IsUsable(command.steer_angle),
          "a commanded speed and steering angle must be finite");
  for (double limit : {command.steering_rate, command.acceleration, command.jerk}) {
    RequireNotNegative(limit, "a commanded limit must be finite and not negative");
  }
  const double most = settings_.max_steer_angle;
  command_ = command;
  command_.steer_angle = std::clamp(command.steer_angle, -most, most);
  if (actuator_) actuator_->Command();
}

Fastest AckermannDrive::GetFastest() const {
  const double fastest =
      std::max(std::abs(speed()), settings_.linear.Limited(std::abs(command_.speed)));
  const double angle = std::max(std::abs(steer_angle()), std::abs(command_.steer_angle));
  return {fastest * fastest,
          std::max(std::abs(slip_.yaw_rate), fastest * std::tan(angle) / settings_.wheelbase)};
}

void AckermannDrive::Reset() {
  command_ = {};
  command_.steer_angle = steering_.angle = steer_angle();
  speed_ = acceleration_ = steering_.rate = 0.0;
  slip_ = {};
  Stop();
}

VelocityChange AckermannDrive::ChangeSpeed(double target, double dt) {
  DynamicsLimits limits = settings_.linear;
  limits.acceleration = Lower(limits.acceleration, command_.acceleration);
  limits.deceleration = Lower(limits.deceleration, command_.acceleration);
  const double jerk = Lower(settings_.jerk, command_.jerk);
  if (jerk == 0.0) {
    const VelocityChange change = limits.Approach({speed_, 0.0}, {target, 0.0}, dt);
    speed_ = change.reached.x;
    acceleration_ = 0.0;
    return change;
  }
  // With a limited jerk, speed and acceleration change as the angle and rate of a steered wheel do.
  // A reversal passes through rest.
  if (limits.velocity > 0.0) target = std::clamp(target, -limits.velocity, limits.velocity);
  if (target * speed_ < 0.0) target = 0.0;
  const bool is_faster = std::abs(target) > std::abs(speed_);
  const DynamicsLimits of_change{jerk, jerk, is_faster ? limits.acceleration : limits.deceleration};
  const SteeringState from{speed_, acceleration_};
  const double halfway = Steer(from, target, of_change, 0.5 * dt).angle;
  const SteeringState reached = Steer(from, target, of_change, dt);
  const double before = speed_;
  speed_ = reached.angle;
  acceleration_ = reached.rate;
  const double mean = (before + 4.0 * halfway + speed_) / 6.0;  // Simpson's rule
  return {{speed_, 0.0}, {mean, 0.0}};
}

Twist AckermannDrive::Rolling(double speed, double angle) const {
  const double slope = std::tan(angle) / settings_.wheelbase;
  if (settings_.single_track) {  // the speed is that of the centre of mass
    speed /= std::hypot(1.0, slope * settings_.single_track->center_of_mass);
  }
  return {speed, 0.0, speed * slope};
}

Twist AckermannDrive::Slipping(double speed, const Slip& slip) const {
  return {speed * std::cos(slip.angle),
          speed * std::sin(slip.angle) - slip.yaw_rate * settings_.single_track->center_of_mass,
          slip.yaw_rate};
}

Twist AckermannDrive::Present() const {
  const bool slips = settings_.single_track && speed() >= kSlipSpeed;
  return slips ? Slipping(speed(), slip_) : Rolling(speed(), steer_angle());
}

Twist AckermannDrive::Advance(const Twist& target, double dt) {
  DynamicsLimits limits = settings_.steering;
  limits.velocity = Lower(limits.velocity, command_.steering_rate);
  const double from_angle = steer_angle(), from_speed = speed();
  VelocityChange rolling = ChangeSpeed(target.vx, dt);
  if (actuator_) {
    VelocityChange none;
    actuator_->Follow(rolling, none, dt);
  }
  const double halfway = Steer(steering_, target.omega, limits, actuator_, dt);
  if (settings_.single_track && std::min(from_speed, speed()) >= kSlipSpeed) {
    return AdvanceSlip(from_speed, from_angle, dt);
  }
  const Twist twist = Rolling(rolling.mean.x, halfway);
  if (settings_.single_track) {
    const double slope = std::tan(steer_angle()) / settings_.wheelbase;
    slip_ = {Rolling(speed(), steer_angle()).omega,
             std::atan(slope * settings_.single_track->center_of_mass)};
  }
  return twist;
}

// The model is linear in x, the yaw rate and the slip angle: x' = A x + b. It gets stiffer as the
// car gets slower. So it is integrated by the L-stable implicit Runge-Kutta method with two stages,
// of second order (Alexander, "Diagonally implicit Runge-Kutta methods for stiff ODEs", 1977): at
// low speed, x goes to the balance of forces. The mean twist uses the same weights.
Twist AckermannDrive::AdvanceSlip(double from_speed, double from_angle, double dt) {
  const SingleTrack& car = *settings_.single_track;
  const double to_speed = speed(), to_angle = steer_angle();
  const double length = settings_.wheelbase;
  const double rear = car.center_of_mass, front = length - rear;
  const double shift = std::clamp(car.height * (to_speed - from_speed) / dt, -kGravity * front,
                                  kGravity * rear);  // no axle has a negative load
  // Cornering stiffness of an axle per mass [m/s^2 per rad], by its share of the load.
  const double of_front = car.friction * car.front_stiffness * (kGravity * rear - shift) / length;
  const double of_rear = car.friction * car.rear_stiffness * (kGravity * front + shift) / length;
  const double agility = car.mass / car.inertia;

  const double gamma = 1.0 - std::sqrt(0.5);
  const auto stage = [&](const Slip& base, double at) {
    const double v = from_speed + at * (to_speed - from_speed);
    const double angle = from_angle + at * (to_angle - from_angle);
    const double a11 = -agility / v * (front * front * of_front + rear * rear * of_rear);
    const double a12 = agility * (rear * of_rear - front * of_front);
    const double a21 = (rear * of_rear - front * of_front) / (v * v) - 1.0;
    const double a22 = -(of_rear + of_front) / v;
    const double h = gamma * dt;
    const double b1 = base.yaw_rate + h * agility * front * of_front * angle;
    const double b2 = base.angle + h * of_front / v * angle;
    const double m11 = 1.0 - h * a11, m12 = -h * a12, m21 = -h * a21, m22 = 1.0 - h * a22;
    const double determinant = m11 * m22 - m12 * m21;
    return Slip{(b1 * m22 - m12 * b2) / determinant, (m11 * b2 - m21 * b1) / determinant};
  };
  const Slip first = stage(slip_, gamma);
  const double ratio = (1.0 - gamma) / gamma;
  const Slip second = stage({slip_.yaw_rate + ratio * (first.yaw_rate - slip_.yaw_rate),
                             slip_.angle + ratio * (first.angle - slip_.angle)},
                            1.0);
  // Above a critical speed, a car that oversteers would spin ever faster, outside of the validity
  // of the tyre model. So both values are clamped.
  slip_ = {std::clamp(second.yaw_rate, -kMostYawRate, kMostYawRate),
           std::clamp(second.angle, -M_PI_2, M_PI_2)};
  if (!IsUsable(slip_.yaw_rate) || !IsUsable(slip_.angle)) slip_ = {};  // NaN or huge
  const double middle_speed = from_speed + gamma * (to_speed - from_speed);
  const Twist one = Slipping(middle_speed, first), two = Slipping(to_speed, slip_);
  const double w = 1.0 - gamma;
  return {w * one.vx + gamma * two.vx, w * one.vy + gamma * two.vy,
          w * one.omega + gamma * two.omega};
}

void AckermannDrive::BeginStep(b2Body& body, double dt) {
  const double parts_of_step = std::clamp(std::ceil(dt / kLongestPart - 1e-9), 1.0, kMostParts);
  const int parts = static_cast<int>(parts_of_step);
  Twist target{command_.speed, 0.0, command_.steer_angle};
  if (actuator_) target = actuator_->Arrive(target, dt);
  Twist mean = Advance(target, dt / parts);
  if (parts > 1) {
    const auto motion_of = [&](const Twist& twist) {
      const double time = dt / parts;
      return MotionAlong({twist.vx * time, twist.vy * time, twist.omega * time});
    };
    Pose moved = motion_of(mean);
    for (int i = 1; i < parts; ++i) moved = Compose(moved, motion_of(Advance(target, dt / parts)));
    const Vec2 arc = ArcOf({moved.x, moved.y, std::clamp(moved.yaw, -3.0, 3.0)});
    mean = {arc.x / dt, arc.y / dt, moved.yaw / dt};
  }
  Begin(body, mean, dt);
}

void AckermannDrive::EndStep(b2Body& body) {
  motion_.End(body, Present(), actuator_.grip());
  // The axes of all wheels meet in a point of the rear axle's line (Ackermann's steering).
  const double slope = std::tan(steer_angle());
  for (b2RevoluteJoint* const joint : wheels_) {
    if (joint == nullptr) continue;
    const b2Vec2 hub =
        joint->GetBodyA() == &body ? joint->GetLocalAnchorA() : joint->GetLocalAnchorB();
    PlaceSteeredWheel(*joint, body, std::atan2(hub.x * slope, settings_.wheelbase - hub.y * slope));
  }
}

}  // namespace flatland
