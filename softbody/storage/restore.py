"""A world is put into a snapshot, and becomes what a snapshot says."""

from __future__ import annotations

from softbody.bodies.builder import Parts, rings_of
from softbody.bodies.store import FIRST_ROOM, Contents, Store, new_clock
from softbody.collision.contact import remembered, remembering
from softbody.compiler.interrupts import set_together
from softbody.model.settings import PRECISIONS
from softbody.stepping.rested import note_sleepers, rested
from softbody.storage.snapshot import Snapped, checked, snapshot_of
from softbody.storage.snapshot_entries import Snapshot


def snapshot_of_store(store: Store) -> Snapshot:
    """Do what `World.snapshot` says."""
    store.exclusive()
    what = store.model, store.controls, store.state, store.joints, store.names, rested(store.contents)
    kept = remembered(store.contacts), store.settings, store.precision, store.steps, store.time
    return snapshot_of(Snapped(*what, *kept))


def restore(store: Store, snapshot: Snapshot) -> None:
    """Do what `World.restore` says."""
    with store.exclusive():
        model, controls, state, joints, names, at_rest, cache, settings, precision, steps, time = checked(snapshot)
        parts = Parts(model, controls, state, rings_of(model, PRECISIONS[precision]), joints)
        contents = Contents(parts, names, at_rest, is_fresh=False)
        note_sleepers(contents)
        set_together(
            (store, "contents", contents),
            (store, "contacts", remembering(cache, FIRST_ROOM)),
            (store, "settings", settings),
            (store, "precision", precision),
            (store, "clock", new_clock(steps, time)),
            (store, "owed", 0.0),
        )
