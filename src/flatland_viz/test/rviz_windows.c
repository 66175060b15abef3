/* Preloaded into plain rviz by tests: its windows have a size when OpenGL asks for it.

   rviz has three connections to the X server, which do not wait for each other (window_ids.py), and
   draws once more into its window when that is closed. Mesa does not notice that the server has no
   such window, and takes for its size whatever is in memory, such as 168 x 0: llvmpipe then clears
   memory that it has not allocated. */

#define _GNU_SOURCE
#include <X11/Xlib.h>
#include <dlfcn.h>

#define REAL(function) ((__typeof__(&function))dlsym(RTLD_NEXT, #function))

static Display* of_qt; /* the first connection */

Display* XOpenDisplay(const char* name) {
  Display* display = REAL(XOpenDisplay)(name);
  if (of_qt == NULL) {
    of_qt = display;
  } else if (display != NULL) {
    XSynchronize(display, True);
  }
  return display;
}

/* Waits for the parent, a window of Qt's. */
Window XCreateWindow(Display* display, Window parent, int x, int y, unsigned int width,
                     unsigned int height, unsigned int border, int depth, unsigned int class,
                     Visual* visual, unsigned long mask, XSetWindowAttributes* attributes) {
  if (display != of_qt) XSync(of_qt, False);
  return REAL(XCreateWindow)(display, parent, x, y, width, height, border, depth, class, visual,
                             mask, attributes);
}

Status XGetGeometry(Display* display, Drawable drawable, Window* root, int* x, int* y,
                    unsigned int* width, unsigned int* height, unsigned int* border,
                    unsigned int* depth) {
  Status status = REAL(XGetGeometry)(display, drawable, root, x, y, width, height, border, depth);
  if (!status) *width = *height = 1; /* the window is gone */
  return status;
}
