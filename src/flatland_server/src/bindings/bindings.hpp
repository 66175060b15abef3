#pragma once

/// What the parts of the bindings share: Python's handles, and tuples to the core's values.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <exception>
#include <memory>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "flatland_server/world.hpp"

namespace flatland {

namespace py = pybind11;

using Pair = std::pair<double, double>;
using Triple = std::tuple<double, double, double>;

inline Vec2 ToVec2(const Pair& pair) { return {pair.first, pair.second}; }
inline Pose ToPose(const Triple& t) { return {std::get<0>(t), std::get<1>(t), std::get<2>(t)}; }
inline Twist ToTwist(const Triple& t) { return {std::get<0>(t), std::get<1>(t), std::get<2>(t)}; }
inline Pair ToTuple(Vec2 v) { return {v.x, v.y}; }
inline Triple ToTuple(const Pose& pose) { return {pose.x, pose.y, pose.yaw}; }
inline Triple ToTuple(const Twist& twist) { return {twist.vx, twist.vy, twist.omega}; }

/// Calls a Python function for each contact that is told of.
class PyListener : public ContactListener {
 public:
  void SetCallback(const std::shared_ptr<World>& world, py::object callback);
  void OnContact(Contact& contact) override;
  /// Throws what the function has thrown since the last call. Needs the GIL.
  void Rethrow();

 private:
  void Call(const Contact& contact, const py::object& told) const;

  std::weak_ptr<World> world_;
  py::object callback_;
  std::exception_ptr error_;
};

/// A world and who listens to its contacts; the handles of bodies keep both alive.
struct ListenedWorld {
  ListenedWorld(int velocity_iterations, int position_iterations)
      : world(velocity_iterations, position_iterations) {}
  PyListener listener;
  World world;
};

/// Throws what Python's listener of contacts has thrown since the last call. Needs the GIL.
inline void RethrowFromListener(World& world) {
  if (world.contact_listener() != nullptr) {
    static_cast<PyListener*>(world.contact_listener())->Rethrow();
  }
}

struct PyWorld {
  explicit PyWorld(const std::shared_ptr<ListenedWorld>& owner)
      : owner(owner), world(owner, &owner->world) {}
  std::shared_ptr<ListenedWorld> owner;
  std::shared_ptr<World> world;
};

/// A handle and its world.
template <class Handle>
struct Owned {
  std::shared_ptr<World> world;
  Handle handle;
};
using PyBody = Owned<World::Body>;
using PyFixture = Owned<Fixture>;
using PyJoint = Owned<World::Joint>;
using PyDrive = Owned<World::Drive>;
using PyTricycle = Owned<World::Tricycle>;
using PyTween = Owned<World::Tween>;
using PyLidar = Owned<World::LidarHandle>;

/// Unique among the bodies that a world has ever had.
inline uint64_t IdOf(World::Body body) {
  return static_cast<uint64_t>(body.generation) << 32 | body.index;
}

/// Bodies of one world, and the one in whose frame their poses are asked for.
struct RelativePoses {
  RelativePoses(const PyBody& reference, const std::vector<PyBody>& bodies);
  std::vector<Triple> Read() const;

  std::shared_ptr<World> world;
  World::Body reference;
  std::vector<World::Body> bodies;
};

void BindBody(py::class_<PyBody>& body);
void BindRelativePoses(py::module_& m);
void BindFixture(py::class_<PyFixture>& fixture);
void BindMechanisms(py::module_& m);
void BindContacts(py::module_& m);
void BindPriorityGuard(py::module_& m);

}  // namespace flatland
