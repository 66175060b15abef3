/// Contacts in Python: the listener, and the arguments that it gets.

#include <pybind11/operators.h>

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

  /// The same contact from its begin to its end, also when Box2D's world is rebuilt.
  bool operator==(const PyContact& other) const { return a == other.a && b == other.b; }

  Contact& Get() const {
    if (contact == nullptr) {
      throw GoneError("a contact can be used only in the hook that it was given to");
    }
    return *contact;
  }
};

/// A method of Contact, while it can be used.
template <auto method, class Result, class... Arguments>
auto OfContact(Result (Contact::*)(Arguments...)) {
  return [](const PyContact& self, Arguments... arguments) {
    return (self.Get().*method)(arguments...);
  };
}
template <auto method, class Result>
auto OfContact(Result (Contact::*)() const) {
  return [](const PyContact& self) { return (self.Get().*method)(); };
}
template <auto method>
auto OfContact() {
  return OfContact<method>(method);
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
  CallUnlessPythonEnds([&] {
    const py::gil_scoped_acquire acquire;
    const auto wrapped = std::make_shared<PyContact>(
        PyContact{world, &contact, {world, contact.a}, {world, contact.b}});
    try {
      CallUnlessPythonEnds([&] { Call(contact, py::cast(wrapped)); });
    } catch (...) {
      error_ = std::current_exception();
    }
    wrapped->contact = nullptr;
  });
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
      .def_readonly("local_points", &Manifold::local_points);

  py::class_<PyContact, std::shared_ptr<PyContact>>(m, "Contact")
      .def(py::self == py::self)
      .def("__hash__",
           [](const PyContact& self) { return py::hash(py::make_tuple(self.a, self.b)); })
      .def_readonly("fixture_a", &PyContact::a)
      .def_readonly("fixture_b", &PyContact::b)
      .def_property_readonly("touching", OfContact<&Contact::is_touching>())
      .def_property_readonly("enabled", OfContact<&Contact::is_enabled>())
      .def(
          "set_enabled",
          [](PyContact& self, bool enabled) {
            if (self.Get().event != kPreSolve) {
              throw std::logic_error("a contact can be enabled or disabled only in pre_solve");
            }
            self.Get().SetEnabled(enabled);
          },
          py::arg("enabled"))
      .def_property_readonly("points", OfContact<&Contact::Points>())
      .def_property_readonly("normal", OfContact<&Contact::Normal>())
      .def_property("friction", OfContact<&Contact::friction>(), OfContact<&Contact::SetFriction>())
      .def_property("restitution", OfContact<&Contact::restitution>(),
                    OfContact<&Contact::SetRestitution>())
      .def_property("tangent_speed", OfContact<&Contact::tangent_speed>(),
                    OfContact<&Contact::SetTangentSpeed>());
}

}  // namespace flatland
