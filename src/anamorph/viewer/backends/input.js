// What a page and a notebook's widget know of fingers and keys beyond the events of rendercanvas's renderview.js.

const TAKEN = new Set(['F1', 'Tab', 'Ctrl+o', 'Ctrl+s']) // keys for which viewer and browser each have a use

// Have the viewer alone use the keys that come to an element or a window.
export function takeKeys (target) {
  target.addEventListener('keydown', (event) => {
    const held = event.ctrlKey || event.metaKey ? 'Ctrl+' : ''
    if (TAKEN.has(held + event.key)) { event.preventDefault() }
  }, { capture: true })
}

// The fingers that are on an element, by their numbers; the library tells of one pointer at a time.
export function followFingers (element) {
  const fingers = new Map()
  const follow = (event) => {
    if (event.pointerType !== 'touch') { return }
    const finger = event.pointerId
    if (event.type === 'pointerup' || event.type === 'pointercancel') {
      fingers.delete(finger)
    } else if (event.type === 'pointerdown' || fingers.has(finger)) {
      const { left, top } = element.getBoundingClientRect()
      fingers.set(finger, { x: event.clientX - left, y: event.clientY - top, pressure: event.pressure })
    }
  }
  for (const type of ['pointerdown', 'pointermove', 'pointerup', 'pointercancel']) {
    element.addEventListener(type, follow, { capture: true })
  }
  return fingers
}

// An event of the library's, completed with all fingers that are down.
export function withFingers (event, fingers) {
  if (!event.type.startsWith('pointer_')) { return event }
  return { ...event, ntouches: fingers.size, touches: Object.fromEntries(fingers) }
}
