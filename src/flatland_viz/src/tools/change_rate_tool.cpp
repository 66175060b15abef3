#include "change_rate_tool.hpp"

#include <flatland_msgs/ChangeRate.h>
#include <rviz/display_context.h>
#include <rviz/properties/editable_enum_property.h>
#include <rviz/window_manager_interface.h>

#include "error_text.hpp"
#include "rate.hpp"
#include "state_subscriber.hpp"

namespace flatland_viz {

using flatland_msgs::ChangeRate;

ChangeRateTool::ChangeRateTool()
    : rate_(new rviz::EditableEnumProperty("Rate", "", "Simulated seconds per second of real time.",
                                           getPropertyContainer())) {
  shortcut_key_ = 'r';
  rate_->setShouldBeSaved(false);
  for (const QString& rate : CommonRates()) rate_->addOption(rate);
  connect(rate_, &rviz::Property::changed, this, [this] { OnPropertyEdited(); });
}

ChangeRateTool::~ChangeRateTool() {
  if (dialog_) dialog_->deleteLater();
}

void ChangeRateTool::onInitialize() {
  OneShotTool::onInitialize();
  subscriber_ = SubscribeToState(
      *context_, [this](const flatland_msgs::SimulationState& state) { Follow(state); });
}

void ChangeRateTool::Run() {
  if (!dialog_) {
    rviz::WindowManagerInterface* windows = context_->getWindowManager();
    dialog_ = new RateDialog(windows ? windows->getParentWindow() : nullptr);
    dialog_->setAttribute(Qt::WA_DeleteOnClose);
    connect(dialog_, &RateDialog::Submitted, this, &ChangeRateTool::Send);
    if (state_) dialog_->ShowState(*state_);
  }
  dialog_->open();
  dialog_->raise();
  dialog_->activateWindow();  // gives it the keyboard where there is no window manager
}

void ChangeRateTool::Send(double rate) {
  ChangeRate::Request request;
  request.rate = rate;
  server_.Call<ChangeRate>("/change_rate", request,
                           [this](const QString& error, const ChangeRate::Response& response) {
                             if (!error.isEmpty()) {
                               ShowError(error);
                             } else if (!response.success) {
                               ShowError(QString::fromStdString(ErrorText(response.message)));
                             } else if (dialog_) {
                               dialog_->close();
                             }
                           });
}

void ChangeRateTool::Follow(const flatland_msgs::SimulationState& state) {
  const bool is_other_rate = !state_ || state_->rate != state.rate;
  state_ = state;
  if (is_other_rate) ShowPresentRate();
  if (dialog_) dialog_->ShowState(state);
}

void ChangeRateTool::OnPropertyEdited() {
  if (is_following_) return;
  const auto rate = ParseRate(rate_->getString());
  if (rate) {
    Send(*rate);
  } else {
    ShowError(QString("\"%1\" is not a number.").arg(rate_->getString()));
  }
}

void ChangeRateTool::ShowPresentRate() {
  is_following_ = true;
  rate_->setString(state_ ? FormatRate(state_->rate) : QString());
  is_following_ = false;
}

void ChangeRateTool::ShowError(const QString& error) {
  ShowPresentRate();
  if (dialog_) {
    dialog_->ShowError(error);
  } else {
    setStatus(error.toHtmlEscaped());
  }
}

}  // namespace flatland_viz
