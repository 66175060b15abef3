#pragma once

/// Shared by the parts of the bindings: the classes that Python gets, and conversions of tuples.

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <exception>
#include <memory>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "bindings/gil.hpp"
#include "world/world.hpp"

namespace flatland {

namespace py = pybind11;

using Pair = std::tuple<double, double>;
using Triple = std::tuple<double, double, double>;

inline Pair ToTuple(Vec2 v) { return {v.x, v.y}; }
inline Triple ToTuple(const Pose& pose) { return {pose.x, pose.y, pose.yaw}; }
inline Triple ToTuple(const Twist& twist) { return {twist.vx, twist.vy, twist.omega}; }
inline Pair ToTuple(const JointMotor& motor) { return {motor.speed, motor.max_torque}; }

}  // namespace flatland

namespace pybind11::detail {

/// Converts a struct out of a tuple of its fields, and into one where there is a ToTuple for it.
template <class Struct, class... Fields>
class StructCaster {
  using Tuple = make_caster<std::tuple<Fields...>>;

 public:
  PYBIND11_TYPE_CASTER(Struct, Tuple::name);

  bool load(handle source, bool convert) {
    Tuple tuple;
    if (!tuple.load(source, convert)) return false;
    value = std::apply([](const Fields&... fields) { return Struct{fields...}; },
                       cast_op<std::tuple<Fields...>>(std::move(tuple)));
    return true;
  }
  static handle cast(const Struct& from, return_value_policy policy, handle parent) {
    return Tuple::cast(ToTuple(from), policy, parent);
  }
};

template <>
struct type_caster<flatland::Vec2> : StructCaster<flatland::Vec2, double, double> {};
template <>
struct type_caster<flatland::Pose> : StructCaster<flatland::Pose, double, double, double> {};
template <>
struct type_caster<flatland::Twist> : StructCaster<flatland::Twist, double, double, double> {};
template <>
struct type_caster<flatland::JointMotor> : StructCaster<flatland::JointMotor, double, double> {};

}  // namespace pybind11::detail

namespace flatland {

template <class T>
using Array = py::array_t<T, py::array::c_style>;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;

/// Segments out of an array (n, 4): x1, y1, x2, y2 [m].
std::vector<Segment> ToSegments(const Doubles& rows);
b2BodyType ToBodyType(const std::string& name);

/// Calls a Python function for each contact event.
class PyListener : public ContactListener {
 public:
  void SetCallback(const std::shared_ptr<World>& world, py::object callback);
  void OnContact(Contact& contact) override;
  /// Throws the first exception that the function has raised since the last call. Needs the GIL.
  void Rethrow();

 private:
  void Call(const Contact& contact, const py::object& wrapped) const;

  std::weak_ptr<World> world_;
  py::object callback_;
  std::exception_ptr error_;
};

/// A world and its contact listener. Handles of bodies and other things keep both alive.
struct ListenedWorld {
  ListenedWorld(int velocity_iterations, int position_iterations)
      : world(velocity_iterations, position_iterations) {}
  PyListener listener;
  World world;
};

/// Throws the first exception that the contact listener has raised since the last call. Needs the
/// GIL.
inline void RethrowFromListener(World& world) {
  if (world.contacts().listener() != nullptr) {
    static_cast<PyListener*>(world.contacts().listener())->Rethrow();
  }
}

struct PyWorld {
  explicit PyWorld(const std::shared_ptr<ListenedWorld>& owner)
      : owner(owner), world(owner, &owner->world) {}
  std::shared_ptr<ListenedWorld> owner;
  std::shared_ptr<World> world;
};

/// A handle in Python: the handle, and the world that it belongs to.
template <class Handle>
struct Owned {
  std::shared_ptr<World> world;
  Handle handle;

  bool operator==(const Owned& other) const {
    return world == other.world && handle == other.handle;
  }
};
using PyBody = Owned<World::Body>;
using PyFixture = Owned<Fixture>;
using PyJoint = Owned<World::Joint>;
using PyDrive = Owned<World::Drive>;
using PyTricycle = Owned<World::Tricycle>;
using PyAckermann = Owned<World::Ackermann>;
using PyTween = Owned<World::Tween>;
using PyDrift = Owned<World::Drift>;
using PyCrowd = Owned<World::CrowdHandle>;
using PyLidar = Owned<World::LidarHandle>;

/// A number that no other body of a world has or had.
inline uint64_t IdOf(World::Body body) {
  return static_cast<uint64_t>(body.generation) << 32 | body.index;
}

// OfWorld<&World::Method>() is a method of the handles that World::Method takes first, and
// OfPart<&BodyDrive::Method>() one of the handles of drives, tweens and drifts.

template <auto method, class Result, class Handle, class... Arguments>
auto OfWorld(Result (World::*)(Handle, Arguments...)) {
  return [](const Owned<Handle>& self, Arguments... arguments) {
    return ((*self.world).*method)(self.handle, std::forward<Arguments>(arguments)...);
  };
}
template <auto method, class Result, class Handle, class... Arguments>
auto OfWorld(Result (World::*)(Handle, Arguments...) const) {
  return OfWorld<method>(static_cast<Result (World::*)(Handle, Arguments...)>(nullptr));
}
template <auto method>
auto OfWorld() {
  return OfWorld<method>(method);
}

template <auto method, class Part, class Result>
auto OfPart(Result (Part::*)() const) {
  return [](const Owned<Handle<Mounted<Part>>>& self) {
    return (self.world->Get(self.handle).*method)();
  };
}
template <auto method>
auto OfPart() {
  return OfPart<method>(method);
}

// BindX(module) adds classes to the module. BindXOf(class) adds the methods that make them to a
// class.
void BindLidar(py::module_& m);
void BindLidarsOf(py::class_<PyBody>& body);
void BindScansOf(py::class_<PyWorld>& world);
void BindJoint(py::module_& m);
void BindJointsOf(py::class_<PyBody>& body);
void BindDrive(py::module_& m);
void BindDrivesOf(py::class_<PyBody>& body);
void BindCrowd(py::module_& m);
void BindCrowdsOf(py::class_<PyWorld>& world);
void BindBody(py::class_<PyBody>& body);
void BindBodyGroup(py::module_& m);
void BindMessages(py::module_& m);
void BindFixture(py::class_<PyFixture>& fixture);
void BindFixturesOf(py::class_<PyBody>& body);
void BindFloorSquares(py::module_& m);
void BindGoalObserver(py::module_& m);
void BindContacts(py::module_& m);
void BindPriorityGuard(py::module_& m);
void BindRangeNoise(py::module_& m);
void BindWorldBatch(py::module_& m);

/// Gives everything in the module its docstring. Returns false, with Python's error set, if the
/// stub names something that the module lacks.
bool SetDocs(PyObject* module);

}  // namespace flatland
