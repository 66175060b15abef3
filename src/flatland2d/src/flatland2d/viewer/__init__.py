"""The window of `flatland view`: shows a simulation, and drives its robots.

Only the module `window` needs pygame.
"""
