"""The window of `flatland view`: draws a simulation, and drives its robots. Only `window` needs pygame."""
