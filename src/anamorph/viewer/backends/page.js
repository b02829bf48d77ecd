// What the page does: shows the images that the viewer sends, and sends back what its user does.
// The messages are those of rendercanvas's http canvas; the events are made by its renderview.js.

import { followFingers, takeKeys, withFingers } from './input.js'

const status = document.getElementById('status')
const wrapper = document.getElementById('canvas')
const SLOWEST_RETRY = 4000 // milliseconds

const CONFIRMATION = '_framefeedback'

let socket = null
let retry = 250
let active = null

class View extends window.BaseRenderView {
  constructor () {
    const image = document.createElement('img')
    image.alt = 'The view, with its controls in the image. The key ? lists what keys do.'
    image.decoding = 'sync'
    image.style.imageRendering = 'pixelated'
    image.style.touchAction = 'none'
    image.ondragstart = () => false
    super(image, wrapper)
    this.setCssWidth('100vw')
    this.setCssHeight('100vh')
    this.setThrottle(16)
    this.frames = []
    this.waiting = false
    this.fingers = followFingers(image)
    image.onload = () => this.showSoon()
  }

  onEvent (event) {
    // What a tab that watches would say of its pointer would be heard by nobody.
    if (active !== true && event.type !== CONFIRMATION) { return }
    if (socket !== null && socket.readyState === WebSocket.OPEN) {
      socket.send(JSON.stringify(withFingers(event, this.fingers)))
    }
  }

  receive (frame) {
    this.frames.push(frame)
    this.showSoon()
  }

  showSoon () {
    if (document.hidden) {
      // No animation frames come to a tab that is not seen; what is drawn there must not stop for it.
      while (this.frames.length > 0) { this.show(this.frames.shift()) }
    } else if (!this.waiting && this.frames.length > 0) {
      this.waiting = true
      window.requestAnimationFrame(() => {
        this.waiting = false
        if (this.frames.length > 0) { this.show(this.frames.shift()) }
      })
    }
  }

  show (frame) {
    const before = this.viewElement.src
    this.viewElement.src = URL.createObjectURL(new Blob([frame.data], { type: frame.mimetype }))
    if (before.startsWith('blob:')) { URL.revokeObjectURL(before) }
    this.onEvent({ type: CONFIRMATION, index: frame.index, timestamp: frame.timestamp, localtime: Date.now() / 1000 })
  }

  // Have the observer tell the size anew: whoever draws knows only that of the tab which has controlled so far.
  tellSize () {
    this._resizeObserver.unobserve(this.viewElement)
    this._resizeObserver.observe(this.viewElement)
  }

  // Let go of what another tab may have held when it was closed.
  release () {
    const pointer = { x: -1, y: -1, buttons: [], modifiers: [], ntouches: 0, touches: {}, timestamp: performance.now() / 1000 }
    for (const button of [1, 2, 3]) { this.onEvent({ type: 'pointer_up', button, ...pointer }) }
  }

  focus () {
    // A touch screen must not bring up its keyboard for it.
    this._focusElement.inputMode = window.matchMedia('(pointer: fine)').matches ? '' : 'none'
    this._focusElement.focus({ preventScroll: true })
  }
}

const view = new View()

function say (text) {
  status.textContent = text
}

function control (value) {
  const gained = value && active !== true
  active = value
  say(value ? '' : 'Watching: another tab controls this viewer. Close it to take over.')
  if (gained) {
    view.release()
    view.tellSize()
    view.focus()
  }
}

function connect () {
  const opened = new WebSocket(`ws://${window.location.host}${window.location.pathname}stream`)
  opened.binaryType = 'arraybuffer'
  let announced = null
  opened.onopen = () => {
    socket = opened
    retry = 250
  }
  opened.onmessage = (message) => {
    if (typeof message.data !== 'string') {
      view.receive({ ...announced, data: message.data })
      return
    }
    const said = JSON.parse(message.data)
    if (said.type === 'framebufferdata') {
      announced = said
    } else if (said.type === 'active') {
      control(said.value)
    } else if (said.type === 'cursor') {
      view.setCursor(said.value)
    } else if (said.type === 'title') {
      document.title = said.value
    }
  }
  opened.onclose = () => {
    socket = null
    active = null
    view.frames.length = 0
    say('Disconnected. Trying again …')
    window.setTimeout(connect, retry)
    retry = Math.min(2 * retry, SLOWEST_RETRY)
  }
}

// The same size in the page can become another on the screen: in a window that is moved to a finer one.
function watchRatio () {
  window.matchMedia(`(resolution: ${window.devicePixelRatio}dppx)`).addEventListener('change', () => {
    view.tellSize()
    watchRatio()
  }, { once: true })
}

document.addEventListener('visibilitychange', () => view.showSoon())
document.addEventListener('contextmenu', (event) => event.preventDefault())
document.addEventListener('pointerenter', () => view.focus(), { capture: true, once: true })
window.addEventListener('focus', () => view.focus())
takeKeys(window)

say('Connecting …')
watchRatio()
connect()
