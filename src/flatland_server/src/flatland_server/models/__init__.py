"""What a world consists of: layers, and models with their bodies, footprints and joints."""
