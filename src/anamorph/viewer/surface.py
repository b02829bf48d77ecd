"""What draws on the viewer's canvas: the halves, what is in space over them, and imgui over all."""

from __future__ import annotations

import numpy as np
from rendercanvas.base import BaseRenderCanvas
from wgpu.utils.imgui import ImguiRenderer

from anamorph.gpu.device import get_device
from anamorph.viewer.compose import Composer, Shown
from anamorph.viewer.lines import LineRenderer
from anamorph.viewer.theme import set_theme


class Surface:
    """Of one canvas, on one device."""

    def __init__(self, canvas: BaseRenderCanvas) -> None:
        self._context = canvas.get_wgpu_context()
        # Colours come out of the shaders, and of imgui, as sRGB already.
        form = self._context.get_preferred_format(get_device().adapter).removesuffix("-srgb")
        self._context.configure(device=get_device(), format=form)
        self.imgui = ImguiRenderer(get_device(), canvas)
        set_theme()
        self._composer = Composer(form)
        self.lines = LineRenderer(form)

    def draw(
        self,
        halves: tuple[Shown, ...],
        divider: float,
        area: tuple[int, int, int, int],
        clip: np.ndarray,
        ratio: float,
    ) -> None:
        """Draw all but imgui.

        Parameters
        ----------
        halves, divider
            As for `Composer.draw`.
        area : (left, top, width, height)
            The picture's, in pixels of the canvas.
        clip : (4, 4) float64
            From world space to the clip space of the picture.
        ratio : float
            Pixels for each logical one.
        """
        encoder = get_device().create_command_encoder()
        attachment = {
            "view": self._context.get_current_texture().create_view(),
            "clear_value": (0.0, 0.0, 0.0, 1.0),
            "load_op": "clear",
            "store_op": "store",
        }
        render_pass = encoder.begin_render_pass(color_attachments=[attachment])
        self._composer.draw(render_pass, halves, area, divider)
        if min(area[2:]) > 0:
            self.lines.draw(render_pass, clip, area[2:], ratio)
        render_pass.end()
        get_device().queue.submit([encoder.finish()])
