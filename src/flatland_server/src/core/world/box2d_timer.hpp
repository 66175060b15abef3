#pragma once

/// Box2D's timing of its own steps, which is switched off; see box2d_timer.cpp.

namespace flatland {

/// True if Box2D reads the clock while it steps. It does if the dynamic linker binds the timer of a
/// shared libbox2d within that library; the results are the same.
bool Box2DReadsClock();

}  // namespace flatland
