/// Contacts in Python: the listener, and the arguments that it gets.

#include "bindings/bindings.hpp"

namespace flatland {
namespace {

/// A contact for Python. Python may keep it, but after the call that it was made for its use raises
/// GoneError.
struct PyContact {
  std::shared_ptr<World> world;
  Contact* contact;
  PyFixture a;
  PyFixture b;

  /// Identifies the contact from its begin to its end, also when Box2D's world is rebuilt.
  std::tuple<uint64_t, uint32_t, uint64_t, uint32_t> Key() const {
    return {IdOf(a.handle.body), a.handle.index, IdOf(b.handle.body), b.handle.index};
  }

  Contact& Get() const {
    if (contact == nullptr) {
      throw GoneError("a contact can be used only in the hook that it was given to");
    }
    return *contact;
  }
};

std::vector<Pair> ToTuples(const std::vector<Vec2>& points) {
  std::vector<Pair> tuples;
  for (const Vec2& point : points) tuples.push_back(ToTuple(point));
  return tuples;
}

}  // namespace

void PyListener::SetCallback(const std::shared_ptr<World>& world, py::object callback) {
  world_ = world;
  callback_ = std::move(callback);
}

void PyListener::Call(const Contact& contact, const py::object& wrapped) const {
  const int event = contact.event;
  const uint64_t a = IdOf(contact.a.body), b = IdOf(contact.b.body);
  if (contact.event == kPreSolve) {
    callback_(event, a, b, wrapped, contact.old_manifold);
  } else if (contact.event == kPostSolve) {
    callback_(event, a, b, wrapped, contact.impulse);
  } else {
    callback_(event, a, b, wrapped);
  }
}

void PyListener::OnContact(Contact& contact) {
  const std::shared_ptr<World> world = world_.lock();
  if (error_ || !world) return;
  const py::gil_scoped_acquire acquire;
  const auto wrapped = std::make_shared<PyContact>(
      PyContact{world, &contact, {world, contact.a}, {world, contact.b}});
  try {
    Call(contact, py::cast(wrapped));
  } catch (...) {
    error_ = std::current_exception();
  }
  wrapped->contact = nullptr;
}

void PyListener::Rethrow() {
  if (error_) std::rethrow_exception(std::exchange(error_, nullptr));
}

void BindContacts(py::module_& m) {
  m.attr("BEGIN_CONTACT") = static_cast<int>(kBeginContact);
  m.attr("END_CONTACT") = static_cast<int>(kEndContact);
  m.attr("PRE_SOLVE") = static_cast<int>(kPreSolve);
  m.attr("POST_SOLVE") = static_cast<int>(kPostSolve);

  py::class_<ContactImpulse>(m, "ContactImpulse")
      .def_readonly("normal_impulses", &ContactImpulse::normal_impulses)
      .def_readonly("tangent_impulses", &ContactImpulse::tangent_impulses);
  py::class_<Manifold, ContactImpulse>(m, "Manifold")
      .def_property_readonly("local_points",
                             [](const Manifold& self) { return ToTuples(self.local_points); });

  py::class_<PyContact, std::shared_ptr<PyContact>>(m, "Contact")
      .def(
          "__eq__",
          [](const PyContact& self, const PyContact& other) {
            return self.world == other.world && self.Key() == other.Key();
          },
          py::is_operator())
      .def("__hash__", [](const PyContact& self) { return py::hash(py::cast(self.Key())); })
      .def_readonly("fixture_a", &PyContact::a)
      .def_readonly("fixture_b", &PyContact::b)
      .def_property_readonly("touching",
                             [](const PyContact& self) { return self.Get().is_touching(); })
      .def_property_readonly("enabled",
                             [](const PyContact& self) { return self.Get().is_enabled(); })
      .def(
          "set_enabled",
          [](PyContact& self, bool enabled) {
            if (self.Get().event != kPreSolve) {
              throw std::logic_error("a contact can be enabled or disabled only in pre_solve");
            }
            self.Get().SetEnabled(enabled);
          },
          py::arg("enabled"))
      .def_property_readonly("points",
                             [](const PyContact& self) { return ToTuples(self.Get().Points()); })
      .def_property_readonly("normal",
                             [](const PyContact& self) { return ToTuple(self.Get().Normal()); })
      .def_property(
          "friction", [](const PyContact& self) { return self.Get().friction(); },
          [](PyContact& self, double value) { self.Get().SetFriction(value); })
      .def_property(
          "restitution", [](const PyContact& self) { return self.Get().restitution(); },
          [](PyContact& self, double value) { self.Get().SetRestitution(value); })
      .def_property(
          "tangent_speed", [](const PyContact& self) { return self.Get().tangent_speed(); },
          [](PyContact& self, double value) { self.Get().SetTangentSpeed(value); });
}

}  // namespace flatland
