/// Box2D's b2Timer without a clock.
///
/// The need. b2World::Step fills a b2Profile: it reads the clock ten times in a step with a moving
/// body, and twice more for each time of impact. Nothing here asks for the profile, and in a small
/// world the clock takes more time than the simulation.
///
/// The method. b2Timer's functions are defined here a second time, and the linker prefers them:
///
/// - Box2D is a static library: its b2_timer.o is not linked, since nothing is missing without it.
/// - Box2D is a shared library: its calls of b2Timer are bound when it is loaded, to the first
///   definition in the order in which the dynamic linker searches (System V ABI, "Shared Object
///   Dependencies"): the program, and then the extension module that has caused the loading, before
///   the libraries that it depends on. Other programs on this machine are not concerned.
///
/// They stay bound to the library's own functions if this was linked with -Bsymbolic-functions, or
/// if another module of the same process has loaded it before. Steps are slower then, and equal to
/// the last bit: no result depends on a time.

#include "world/box2d_timer.hpp"

#include <box2d/box2d.h>

b2Timer::b2Timer() = default;

void b2Timer::Reset() {}

float b2Timer::GetMilliseconds() const { return 0.0f; }

namespace flatland {

bool Box2DReadsClock() {
  // A step may be shorter than Box2D's resolution of a microsecond, but not a thousand of them.
  constexpr int kSteps = 1000;
  b2World world(b2Vec2_zero);
  for (int i = 0; i < kSteps; ++i) {
    world.Step(0.01f, 1, 1);
    if (world.GetProfile().step != 0.0f) return true;
  }
  return false;
}

}  // namespace flatland
