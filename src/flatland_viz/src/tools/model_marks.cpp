#include "model_marks.hpp"

#include <OgreSceneManager.h>
#include <OgreSceneNode.h>
#include <OgreViewport.h>

#include <QRectF>
#include <algorithm>
#include <array>
#include <cmath>

#include "flat_shape.hpp"
#include "model_handle.hpp"
#include "name_label.hpp"
#include "screen_scale.hpp"
#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

constexpr float kMarkZ = 0.2f;          // m: above the models
constexpr double kMinArrow = 9;         // pixels from the middle to the tip
constexpr double kMaxArrow = 11.5;      // 28 pixels from end to end, with its outline
constexpr double kArrowPart = 0.45;     // of the robot's radius
constexpr double kArrowContrast = 200;  // least difference of an arrow's colour from its body's
constexpr double kGap = 4;              // pixels between a model's handle and its name
constexpr double kOutline = 1.35;       // of the arrow's size, where it stands alone
constexpr std::size_t kCrowd = 300;     // more models than this are not kept free of names
constexpr double kRing = 2.5;           // pixels: width of the ring on a robot's base

struct Colors {
  QColor text, plate, outline;
};

Colors ColorsOn(const QColor& background) {
  if (background.lightnessF() > 0.5) {
    return {QColor(45, 48, 52), QColor(255, 255, 255, 205), QColor(255, 255, 255, 235)};
  }
  return {QColor(225, 228, 232), QColor(38, 41, 46, 215), QColor(20, 22, 25, 235)};
}

/// The perceived difference of two colours, 0 to 765 (CompuPhase's approximation).
double Difference(const QColor& a, const QColor& b) {
  const double mean = (a.red() + b.red()) / 2.0, r = a.red() - b.red(), g = a.green() - b.green(),
               blue = a.blue() - b.blue();
  return std::sqrt((2 + mean / 256) * r * r + 4 * g * g + (2 + (255 - mean) / 256) * blue * blue);
}

QColor BodyColor(const WorldModel& model) {
  const std_msgs::ColorRGBA& color = model.info.bodies.front().color;
  const auto channel = [](float value) { return std::clamp(static_cast<double>(value), 0.0, 1.0); };
  return QColor::fromRgbF(channel(color.r), channel(color.g), channel(color.b));
}

/// The colour of a robot's arrow: its own, or white or black if that is too near to its body's.
QColor ArrowColor(const WorldModel& model) {
  const QColor body = BodyColor(model);
  if (Difference(model.color(), body) >= kArrowContrast) return model.color();
  return Difference(Qt::white, body) > Difference(Qt::black, body) ? QColor(Qt::white)
                                                                   : QColor(Qt::black);
}

/// The outline of an arrow that also stands out from it.
QColor OutlineOf(const QColor& arrow, const QColor& usual) {
  if (Difference(arrow, usual) >= kArrowContrast) return usual;
  return Difference(arrow, Qt::white) > Difference(arrow, Qt::black) ? QColor(255, 255, 255, 235)
                                                                     : QColor(20, 22, 25, 235);
}

/// The text on a plate of a colour.
QColor TextOn(const QColor& plate) {
  return Difference(plate, Qt::white) > Difference(plate, Qt::black) ? QColor(Qt::white)
                                                                     : QColor(Qt::black);
}

/// The shape of a navigation arrow that looks along x: its tip is at 1.
void AddArrow(FlatShape& shape, double size, const QColor& color) {
  const auto point = [size](double x, double y) {
    return Ogre::Vector2(static_cast<float>(size * x), static_cast<float>(size * y));
  };
  const Ogre::Vector2 tip = point(1.0, 0.0), notch = point(-0.42, 0.0);
  shape.AddTriangle(tip, point(-0.8, 0.72), notch, color);
  shape.AddTriangle(tip, notch, point(-0.8, -0.72), color);
}

/// The places of models in the view, which names must not cover [pixels].
std::vector<QRectF> Bodies(const std::vector<const WorldModel*>& models, const WorldPlane& world,
                           const Ogre::Viewport& viewport, double pixel_ratio) {
  std::vector<QRectF> places;
  for (const WorldModel* model : models) {
    if (!model->is_placed() || models.size() > kCrowd) continue;
    const Ogre::Vector3 at = world.PositionInScene(model->MiddleAt(model->state.pose), kMarkZ);
    const Ogre::Vector2 seen = OnScreen(at, viewport);
    // A square in its circle: the corners of the box around it are mostly empty.
    const double reach =
        std::max(0.7 * model->radius() * ScreenScale::At(at, viewport).pixels_per_metre,
                 kMinArrow * pixel_ratio);
    places.emplace_back(seen.x - reach, -seen.y - reach, 2 * reach, 2 * reach);
  }
  return places;
}

/// Moves a name away from the edge of the view so that it is not cut off, unless the named model is
/// out of sight.
void MoveIntoView(QRectF& place, const QPointF& model, const Ogre::Viewport& viewport) {
  QRectF view(0, 0, viewport.getActualWidth(), viewport.getActualHeight());
  view.moveCenter(QPointF());
  if (!view.contains(model)) return;
  place.moveRight(std::min(place.right(), view.right()));
  place.moveLeft(std::max(place.left(), view.left()));
  place.moveBottom(std::min(place.bottom(), view.bottom()));
}

}  // namespace

struct ModelMarks::Mark {
  Mark(Ogre::SceneManager& scene, Ogre::SceneNode& parent)
      : ring(scene, parent, 0), heading(scene, parent, 1), label(scene, parent) {}

  FlatShape ring;
  double ring_radius = 0.0;  // as it is drawn [pixels]
  QColor ring_color;
  FlatShape heading;
  NameLabel label;
  QColor color, outline;  // of the heading, as it is drawn
};

ModelMarks::ModelMarks(Ogre::SceneManager& scene, Ogre::SceneNode& parent)
    : scene_(scene), parent_(parent) {}

ModelMarks::~ModelMarks() = default;

void ModelMarks::Update(const WorldModels& models, const WorldPlane& world,
                        const Ogre::Viewport& viewport, const Options& options) {
  for (auto mark = marks_.begin(); mark != marks_.end();) {
    mark = models.Find(mark->first) ? std::next(mark) : marks_.erase(mark);
  }
  std::vector<const WorldModel*> order;
  for (const auto& [name, model] : models.models()) order.push_back(&model);
  const auto importance = [&](const WorldModel* model) {
    const std::string& name = model->info.name;
    return name == models.selected() ? 0 : name == models.hovered() ? 1 : 2;
  };
  std::stable_sort(order.begin(), order.end(),
                   [&](const auto* a, const auto* b) { return importance(a) < importance(b); });

  const Colors colors = ColorsOn(options.background);
  std::vector<QRectF> taken = Bodies(order, world, viewport, options.pixel_ratio);
  for (const WorldModel* model : order) {
    std::unique_ptr<Mark>& mark = marks_[model->info.name];
    if (!mark) mark = std::make_unique<Mark>(scene_, parent_);
    if (!model->is_placed()) continue;
    PlaceHeading(*mark, *model, world, viewport, options);

    const bool is_selected = importance(model) == 0;
    bool is_shown = options.labels && (model->is_robot() || importance(model) < 2);
    if (is_shown) {
      LabelStyle style{colors.text, colors.plate, options.pixel_ratio};
      if (is_selected) style.plate = model->is_robot() ? model->color() : QColor(70, 76, 84);
      if (is_selected) style.text = TextOn(style.plate);
      mark->label.Set(QString::fromStdString(model->info.name), style);

      std::vector<QRectF> none;
      is_shown = PlaceLabel(*mark, *model, world, viewport, options, taken) ||
                 (is_selected && PlaceLabel(*mark, *model, world, viewport, options, none));
    }
    mark->label.SetVisible(is_shown);
  }
}

bool ModelMarks::PlaceLabel(Mark& mark, const WorldModel& model, const WorldPlane& world,
                            const Ogre::Viewport& viewport, const Options& options,
                            std::vector<QRectF>& taken) {
  const Ogre::Vector3 at = world.PositionInScene(model.MiddleAt(model.state.pose), kMarkZ);
  const ScreenScale scale = ScreenScale::At(at, viewport);
  const double handle = ModelHandle::Radius(model, scale.pixels_per_metre, options.pixel_ratio) *
                        scale.pixels_per_metre;
  const QSizeF size = mark.label.size();
  const double gap = handle + kGap * options.pixel_ratio;
  const double down = gap + size.height() / 2, aside = gap + size.width() / 2;
  const Ogre::Vector2 seen = OnScreen(at, viewport);
  const QPointF middle(seen.x, -seen.y);
  const std::array<QPointF, 4> sides = {QPointF(0, down), {0, -down}, {aside, 0}, {-aside, 0}};
  for (const QPointF& side : sides) {
    QRectF place(QPointF(), size);
    place.moveCenter(middle + side);
    MoveIntoView(place, middle, viewport);
    if (std::any_of(taken.begin(), taken.end(),
                    [&](const QRectF& other) { return other.intersects(place); })) {
      continue;
    }
    const QPointF moved = place.center() - middle;
    mark.label.Place(at + scale.Offset(moved.x(), -moved.y()), viewport);
    taken.push_back(place);
    return true;
  }
  return false;
}

void ModelMarks::PlaceHeading(Mark& mark, const WorldModel& model, const WorldPlane& world,
                              const Ogre::Viewport& viewport, const Options& options) {
  const bool is_shown = options.headings && model.is_robot();
  mark.heading.SetVisible(is_shown);
  mark.ring.SetVisible(false);
  if (!is_shown) return;
  const QColor color = ArrowColor(model);
  const QColor outline = OutlineOf(color, ColorsOn(options.background).outline);
  if (mark.color != color || mark.outline != outline) {
    mark.color = color;
    mark.outline = outline;
    mark.heading.Begin();
    AddArrow(mark.heading, kOutline, outline);
    AddArrow(mark.heading, 1.0, color);
    mark.heading.End();
  }
  // On the base, the body that drives.
  const geometry_msgs::Pose2D& base = model.state.bodies.front();
  const Ogre::Vector3 at = world.PositionInScene(base, kMarkZ);
  const ScreenScale scale = ScreenScale::At(at, viewport);
  const double size = std::clamp(kArrowPart * model.radius() * scale.pixels_per_metre,
                                 kMinArrow * options.pixel_ratio, kMaxArrow * options.pixel_ratio);
  mark.heading.Place(at, world.OrientationInScene(base), scale.Metres(size));
  PlaceRing(mark, model, world, scale, kOutline * size, options.pixel_ratio);
}

void ModelMarks::PlaceRing(Mark& mark, const WorldModel& model, const WorldPlane& world,
                           const ScreenScale& scale, double arrow, double pixel_ratio) {
  const flatland_msgs::BodyInfo& box = model.info.bodies.front();
  const double side = std::min(box.max_x - box.min_x, box.max_y - box.min_y);
  const double width = kRing * pixel_ratio;
  const double radius = side / 2 * scale.pixels_per_metre - width / 2;
  if (radius < arrow + width) return;  // it would be hidden by the arrow
  if (radius != mark.ring_radius || model.color() != mark.ring_color) {
    mark.ring_radius = radius;
    mark.ring_color = model.color();
    mark.ring.Begin();
    mark.ring.AddRing(radius, width, model.color());
    mark.ring.End();
  }
  geometry_msgs::Pose2D middle;
  middle.x = (box.min_x + box.max_x) / 2;
  middle.y = (box.min_y + box.max_y) / 2;
  const geometry_msgs::Pose2D at = Compose(model.state.bodies.front(), middle);
  mark.ring.Place(world.PositionInScene(at, kMarkZ), world.OrientationInScene(at),
                  scale.Metres(1.0));
  mark.ring.SetVisible(true);
}

}  // namespace flatland_viz
