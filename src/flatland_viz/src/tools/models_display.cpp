#include "models_display.hpp"

#include <OgreSceneNode.h>
#include <OgreViewport.h>
#include <rviz/display_context.h>
#include <rviz/display_group.h>
#include <rviz/frame_manager.h>
#include <rviz/properties/bool_property.h>
#include <rviz/properties/color_property.h>
#include <rviz/properties/string_property.h>

#include <QJsonDocument>
#include <QJsonObject>
#include <QRectF>
#include <QStringList>

#include "before_render.hpp"
#include "ground_truth_frames.hpp"
#include "model_marks.hpp"
#include "world_models.hpp"
#include "world_plane.hpp"

namespace flatland_viz {
namespace {

const ros::WallDuration kBoundsPeriod(0.2);

}  // namespace

ModelsDisplay::ModelsDisplay()
    : labels_(new rviz::BoolProperty("Labels", true, "The names of the models.", this,
                                     SLOT(queueRender()))),
      headings_(new rviz::BoolProperty("Headings", true, "Where robots look.", this,
                                       SLOT(queueRender()))),
      colors_(new rviz::StringProperty("Colors", "", "Of the robots.", this)),
      bounds_(new rviz::StringProperty(
          "Bounds", "",
          "The box around all models, \"min_x min_y max_x max_y\" in metres. Empty "
          "without models, and from a change of their list until all of their poses are known.",
          this)),
      places_frames_(new rviz::BoolProperty(
          "Ground Truth", true,
          "While nothing publishes a transform from the map to a robot's odometry frame, place the "
          "robot's frames by its true pose.",
          this)),
      publishes_frames_(new rviz::BoolProperty(
          "Publish To TF", false,
          "Publish these transforms, for all nodes, until a localiser does.", this)),
      placed_frames_(new rviz::StringProperty("Placed Frames", "",
                                              "The frames placed by ground truth now.", this)) {
  placed_frames_->setReadOnly(true);
  placed_frames_->setShouldBeSaved(false);
  colors_->setReadOnly(true);
  colors_->setShouldBeSaved(false);
  colors_->setHidden(true);
  bounds_->setReadOnly(true);
  bounds_->setShouldBeSaved(false);
  bounds_->setHidden(true);
}

ModelsDisplay::~ModelsDisplay() = default;

void ModelsDisplay::onInitialize() {
  models_ = WorldModels::Of(*context_);
  frames_ = std::make_unique<GroundTruthFrames>(context_->getFrameManager()->getTF2BufferPtr(),
                                                *models_, update_nh_);
  connect(models_.get(), &WorldModels::Moved, this,
          [this](const flatland_msgs::ModelStates& states) { frames_->Add(states); });
  marks_ = std::make_unique<ModelMarks>(*scene_manager_, *scene_node_);
  before_render_ = std::make_unique<BeforeRender>(
      *context_, [this](const Ogre::Viewport& viewport, double pixel_ratio) {
        PlaceMarks(viewport, pixel_ratio);
      });
  connect(models_.get(), &WorldModels::Listed, this, &ModelsDisplay::ListColors);
  connect(models_.get(), &WorldModels::Listed, this, [this] { bounds_->setString(""); });
  ListColors();
}

void ModelsDisplay::reset() {
  rviz::Display::reset();
  frames_->Clear();
}

void ModelsDisplay::onEnable() { scene_node_->setVisible(true); }

void ModelsDisplay::onDisable() { scene_node_->setVisible(false); }

void ModelsDisplay::update(float /*wall_dt*/, float /*ros_dt*/) {
  PlaceFrames();
  FollowBounds();
  if (models_->revision() != drawn_revision_) queueRender();
  drawn_revision_ = models_->revision();
}

void ModelsDisplay::PlaceMarks(const Ogre::Viewport& viewport, double pixel_ratio) {
  const auto world = WorldPlane::Find(*context_);
  if (!world || !isEnabled()) return;
  ModelMarks::Options options;
  options.labels = labels_->getBool();
  options.headings = headings_->getBool();
  options.background = Background();
  options.pixel_ratio = pixel_ratio;
  marks_->Update(*models_, *world, viewport, options);
}

QColor ModelsDisplay::Background() const {
  rviz::Property* options = context_->getRootDisplayGroup()->subProp("Global Options");
  const auto* color = dynamic_cast<rviz::ColorProperty*>(options->subProp("Background Color"));
  return color ? color->getColor() : Qt::white;
}

/// Tells the window the colours of the robots, as JSON: {"name": "#rrggbb"}.
void ModelsDisplay::ListColors() {
  QJsonObject colors;
  for (const auto& [name, model] : models_->models()) {
    if (model.is_robot()) colors[QString::fromStdString(name)] = model.color().name();
  }
  colors_->setString(QJsonDocument(colors).toJson(QJsonDocument::Compact));
}

void ModelsDisplay::FollowBounds() {
  const ros::WallTime now = ros::WallTime::now();
  const bool is_due = bounds_->getStdString().empty() || now - bounds_at_ >= kBoundsPeriod;
  if (!is_due || models_->revision() == bounds_revision_) return;
  bounds_at_ = now;
  bounds_revision_ = models_->revision();
  QRectF bounds;
  for (const auto& [name, model] : models_->models()) {
    if (!model.is_placed()) return;
    const double radius = model.radius();
    const QPointF middle = model.middle_in_world();
    bounds |= QRectF(middle.x() - radius, middle.y() - radius, 2 * radius, 2 * radius);
  }
  if (bounds.isNull()) return;
  bounds_->setString(QString("%1 %2 %3 %4")
                         .arg(bounds.left())
                         .arg(bounds.top())
                         .arg(bounds.right())
                         .arg(bounds.bottom()));
}

void ModelsDisplay::PlaceFrames() {
  QStringList placed;
  if (places_frames_->getBool()) {
    frames_->is_published = publishes_frames_->getBool();
    frames_->Update();
    for (const std::string& root : frames_->roots()) placed << QString::fromStdString(root);
  }
  placed_frames_->setString(placed.join(", "));
}

}  // namespace flatland_viz
