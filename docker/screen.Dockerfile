# Flatland with a screen that a browser shows; docs/install.md, "Container", tells how to use it.
#
#   docker build --tag flatland --file docker/Dockerfile .
#   docker build --tag flatland-screen --file docker/screen.Dockerfile .
# hadolint ignore=DL3006
FROM flatland

USER 0
# hadolint ignore=DL3008
RUN apt-get update \
  && DEBIAN_FRONTEND=noninteractive apt-get install --yes --no-install-recommends novnc websockify x11vnc \
  && sed --in-place 's|<applications>|&<application title="Flatland*" type="normal"><maximized>yes</maximized></application>|' \
    /etc/xdg/openbox/rc.xml \
  && rm -rf /var/lib/apt/lists/*

COPY docker/screen.html /usr/share/novnc/index.html

USER 1000
EXPOSE 6080
ENTRYPOINT ["docker/screen"]
