"""What will be computed of the scene: every decision with its reason, its bound, the time that it saves, and its switch."""

import bpy

from ..blender_addon import readout
from ..blender_addon.foundation import background_job
from ..blender_addon.modelling import asked, job, results
from ..blender_addon.modelling.settings import SWITCHES
from ..engine.scene.modelling import Switch
from .parts import draw_lines, draw_text
from .render import RenderPanel

NO_ERROR = "No error is asked for, so only what is exact is simplified"


class LUMENRAY_PT_modelling(RenderPanel, bpy.types.Panel):
    """Decisions about what is simplified, as the engine made them last, and who makes them."""

    bl_label = "What Will Be Computed"
    # Below the panel of the bake, which is registered later.
    bl_order = 1
    bl_options = {"DEFAULT_CLOSED"}

    def draw_settings(self, layout, context, settings):
        """Draw what is asked for, the decisions and the budget; nothing of it is computed here."""
        own, scene = settings.modelling, context.scene
        answer = results.find(scene)
        question = asked.find_question(scene, context.selected_objects)
        layout.prop(own, "purpose")
        column = layout.column()
        column.active = question.error is not None
        column.prop(own, "share_percent", text="Budget")
        draw_text(layout, context, f"{question.words[:1].upper()}{question.words[1:]}", "INFO")
        if question.error is None:
            draw_text(layout, context, NO_ERROR)
        old = "" if answer is None else answer.why_outdated(scene, context.selected_objects)
        row = layout.row()
        row.scale_y = 1.4
        if background_job.is_running(job.NAME):
            row.label(text="Looking at the scene; Esc cancels", icon="TIME")
        else:
            row.operator("lumenray.explain_modelling", icon="VIEWZOOM")
        if old:
            draw_text(layout, context, f"Out of date, changed since: {old}", "ERROR")
        decisions = {} if answer is None else {each.name: each for each in answer.plan.decisions}
        column = layout.column()
        for name, key in SWITCHES.items():
            self._draw_decision(column, context, own, key, decisions.get(name), bool(old))
        if answer is not None:
            column = layout.column()
            column.active = not old
            text = answer.plan.budget_text
            draw_text(column, context, f"{text[:1].upper()}{text[1:]}", "INFO")

    def _draw_decision(self, layout, context, own, key: str, decision, is_old: bool) -> None:
        """Draw the switch of a decision alone, or below its choice together with all that is known of it."""
        if decision is None:
            layout.prop(own, key)
            return
        # What costs exactness is open at first.
        header, body = layout.panel(f"lumenray_modelling_{key}", default_closed=not decision.bound)
        header.active = not is_old
        is_own = decision.switch is not Switch.AUTO
        title = f"{own.bl_rna.properties[key].name}: {decision.choice}"
        if decision.bound:
            title += f", ≤ {readout.format_error(decision.bound)}"
        header.label(text=title, icon="PINNED" if is_own else "NONE")
        if body is None:
            return
        body.prop(own, key)
        column = body.column()
        column.active = not is_old
        lines = [("error", readout.format_bound(decision.bound))]
        if decision.saving:
            lines.append(("time saved", f"about {100.0 * decision.saving:.0f} %"))
        draw_lines(column, lines, share=0.4)
        draw_text(column, context, f"{decision.reason[:1].upper()}{decision.reason[1:]}")


CLASSES = (LUMENRAY_PT_modelling,)
"""For registration."""
