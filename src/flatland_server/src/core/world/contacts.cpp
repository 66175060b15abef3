#include "world/contacts.hpp"

#include <algorithm>
#include <tuple>

namespace flatland {

void Contacts::SetListener(ContactListener* listener) {
  const AccessGuard guard(access_);
  listener_ = listener;
}

void Contacts::ListenTo(Bodies::Body body, ContactEvents events) {
  access_.RequireAccess();
  bodies_.Get(body).contact_events = events;
  ChooseReports();
}

void Contacts::Record(Bodies::Body body) {
  access_.RequireAccess();
  bodies_.Get(body).is_recorded = true;
  ChooseReports();
}

void Contacts::ChooseReports() {
  bool is_any_chosen = false;
  bodies_.ForEach([&](auto, const BodyRecord& record) {
    is_any_chosen |= record.contact_events != kNoContactEvents || record.is_recorded;
  });
  world_->SetContactListener(is_any_chosen ? this : nullptr);
}

bool Contacts::IsListenedTo(b2Contact& contact, ContactEvent event) const {
  if (listener_ == nullptr) return false;
  const auto events = [&](b2Fixture* fixture) {
    return bodies_.RecordOf(*fixture->GetBody()).contact_events;
  };
  return ((events(contact.GetFixtureA()) | events(contact.GetFixtureB())) & event) != 0;
}

bool Contacts::IsRecorded(b2Contact& contact) const {
  return bodies_.RecordOf(*contact.GetFixtureA()->GetBody()).is_recorded ||
         bodies_.RecordOf(*contact.GetFixtureB()->GetBody()).is_recorded;
}

Contact Contacts::MakeContact(b2Contact& contact, ContactEvent event) const {
  const auto fixture = [&](b2Fixture* f) {
    return Fixture{bodies_.HandleOf(*f->GetBody()),
                   static_cast<uint32_t>(f->GetUserData().pointer)};
  };
  return Contact(contact, event, fixture(contact.GetFixtureA()), fixture(contact.GetFixtureB()));
}

// They are sorted, as the order of Box2D's contacts depends on its tree.
std::vector<Touch> Contacts::GetTouches() const {
  access_.RequireAccess();
  std::vector<Touch> touches;
  for (b2Contact* each = world_->GetContactList(); each != nullptr; each = each->GetNext()) {
    if (!each->IsTouching()) continue;
    const Contact contact = MakeContact(*each, kPostSolve);
    touches.push_back({contact.a, contact.b, contact.Points(), contact.Normal()});
  }
  const auto key = [](const Touch& touch) {
    return std::make_tuple(touch.a.body.index, touch.a.index, touch.b.body.index, touch.b.index);
  };
  std::sort(touches.begin(), touches.end(),
            [&](const Touch& one, const Touch& other) { return key(one) < key(other); });
  return touches;
}

bool Contacts::Touches(const std::vector<Bodies::Body>& bodies) const {
  access_.RequireAccess();
  const auto is_own = [&](b2Body& other) {
    const uint32_t index = static_cast<uint32_t>(other.GetUserData().pointer);
    return std::any_of(bodies.begin(), bodies.end(),
                       [&](Bodies::Body body) { return body.index == index; });
  };
  for (const Bodies::Body& body : bodies) {
    b2Body& found = *bodies_.Get(body).body;
    for (b2ContactEdge* edge = found.GetContactList(); edge != nullptr; edge = edge->next) {
      b2Contact& contact = *edge->contact;
      const bool is_solid =
          !contact.GetFixtureA()->IsSensor() && !contact.GetFixtureB()->IsSensor();
      if (contact.IsTouching() && is_solid && !is_own(*edge->other)) return true;
    }
  }
  return false;
}

void Contacts::EndStep(double dt) {
  RunDeferred();
  collisions_.EndStep(dt);
}

void Contacts::RunDeferred() {
  for (const auto& [body, action] : deferred_) {
    if (bodies_.Contains(body)) action(*bodies_.Get(body).body);
  }
  deferred_.clear();
}

void Contacts::CallListener(Contact& contact) {
  ++event_count_;
  access_.CallBack([&] { listener_->OnContact(contact); });
}

void Contacts::BeginContact(b2Contact* contact) {
  if (IsRecorded(*contact)) {
    const bool has_sensor =
        contact->GetFixtureA()->IsSensor() || contact->GetFixtureB()->IsSensor();
    collisions_.Begin(MakeContact(*contact, kBeginContact), has_sensor);
  }
  if (!IsListenedTo(*contact, kBeginContact)) return;
  Contact reported = MakeContact(*contact, kBeginContact);
  CallListener(reported);
}

void Contacts::EndContact(b2Contact* contact) {
  if (IsRecorded(*contact)) {
    const Contact ended = MakeContact(*contact, kEndContact);
    collisions_.End(ended.a, ended.b);
  }
  if (!IsListenedTo(*contact, kEndContact)) return;
  Contact reported = MakeContact(*contact, kEndContact);
  CallListener(reported);
}

void Contacts::PreSolve(b2Contact* contact, const b2Manifold* old_manifold) {
  if (!IsListenedTo(*contact, kPreSolve)) return;
  Contact reported = MakeContact(*contact, kPreSolve);
  for (int i = 0; i < old_manifold->pointCount; ++i) {
    const b2ManifoldPoint& point = old_manifold->points[i];
    reported.old_manifold.local_points.push_back({point.localPoint.x, point.localPoint.y});
    reported.old_manifold.normal_impulses.push_back(point.normalImpulse);
    reported.old_manifold.tangent_impulses.push_back(point.tangentImpulse);
  }
  CallListener(reported);
}

void Contacts::PostSolve(b2Contact* contact, const b2ContactImpulse* impulse) {
  if (IsRecorded(*contact)) {
    collisions_.Solve(MakeContact(*contact, kPostSolve), *impulse);
  }
  if (!IsListenedTo(*contact, kPostSolve)) return;
  Contact reported = MakeContact(*contact, kPostSolve);
  const float* normal = impulse->normalImpulses;
  const float* tangent = impulse->tangentImpulses;
  reported.impulse.normal_impulses.assign(normal, normal + impulse->count);
  reported.impulse.tangent_impulses.assign(tangent, tangent + impulse->count);
  CallListener(reported);
}

}  // namespace flatland
