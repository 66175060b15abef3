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

constexpr float kMarkZ = 0.2f;       // m: above the models
constexpr double kMinArrow = 9;      // pixels from the middle to the tip
constexpr double kMaxArrow = 11.5;   // 28 pixels from end to end, with its outline
constexpr double kArrowPart = 0.45;  // of the robot's radius
constexpr double kGap = 4;           // pixels between a model's handle and its name
constexpr double kOutline = 1.35;    // of the arrow's size, where it stands alone
constexpr std::size_t kCrowd = 300;  // more models than this are not kept free of names
constexpr int kBright = 150;         // grey value from which a plate has black text

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
      : heading(scene, parent, 1), label(scene, parent) {}

  FlatShape heading;
  NameLabel label;
  QColor color;  // of the heading, as it is drawn
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

  const QColor plain = qGray(options.background.rgb()) > kBright ? QColor(255, 255, 255, 205)
                                                                 : QColor(38, 41, 46, 215);
  std::vector<QRectF> taken = Bodies(order, world, viewport, options.pixel_ratio);
  for (const WorldModel* model : order) {
    std::unique_ptr<Mark>& mark = marks_[model->info.name];
    if (!mark) mark = std::make_unique<Mark>(scene_, parent_);
    if (!model->is_placed()) continue;
    PlaceHeading(*mark, *model, world, viewport, options);

    const bool is_selected = importance(model) == 0;
    bool is_shown = options.labels && (model->is_robot() || importance(model) < 2);
    if (is_shown) {
      const QColor strong = model->is_robot() ? model->color() : QColor(70, 76, 84);
      const QColor plate = is_selected ? strong : plain;
      const QColor text = qGray(plate.rgb()) > kBright ? QColor(35, 38, 42) : QColor(235, 237, 240);
      mark->label.Set(QString::fromStdString(model->info.name), {text, plate, options.pixel_ratio});

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
  const double handle =
      ModelHandle::Radius(model, scale.Metres(options.pixel_ratio)) * scale.pixels_per_metre;
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
  if (!is_shown) return;
  if (mark.color != model.color()) {
    mark.color = model.color();
    mark.heading.Begin();
    AddArrow(mark.heading, kOutline, Qt::white);
    AddArrow(mark.heading, 1.0, mark.color);
    mark.heading.End();
  }
  // On the base, the body that drives.
  const geometry_msgs::Pose2D& base = model.state.bodies.front();
  const Ogre::Vector3 at = world.PositionInScene(base, kMarkZ);
  const ScreenScale scale = ScreenScale::At(at, viewport);
  const double size = std::clamp(kArrowPart * model.radius() * scale.pixels_per_metre,
                                 kMinArrow * options.pixel_ratio, kMaxArrow * options.pixel_ratio);
  mark.heading.Place(at, world.OrientationInScene(base), scale.Metres(size));
}

}  // namespace flatland_viz
