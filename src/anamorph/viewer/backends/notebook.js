// What the viewer adds to rendercanvas's widget; this follows input.js and the widget's own code, in one module.

/* global AnywidgetRenderView RenderviewAnywidgetModel followFingers takeKeys withFingers */

const { _registerEvents, onEvent } = AnywidgetRenderView.prototype
const { updateVisibility } = RenderviewAnywidgetModel.prototype

AnywidgetRenderView.prototype._registerEvents = function () {
  this.fingers = followFingers(this.viewElement)
  takeKeys(this._focusElement)
  _registerEvents.call(this)
}

AnywidgetRenderView.prototype.onEvent = function (event) {
  onEvent.call(this, withFingers(event, this.fingers))
}

// It is called whenever there is a view more or less, and sends what is set.
RenderviewAnywidgetModel.prototype.updateVisibility = function () {
  this.anymodel.set('_views', this.views.length)
  updateVisibility.call(this)
}
