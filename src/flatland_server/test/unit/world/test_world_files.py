"""World files: problems of plugins are reported together; `properties` may be empty."""

from world.parts import BODIES, EMPTY


def test_all_plugins_that_do_not_start_are_reported_at_once(models):
    models.write("worse.yaml", f"{BODIES}plugins:\n  - {{type: Talkr, name: a}}\n")
    entries = "models: [{name: a, model: bad.yaml}, {name: b, model: worse.yaml}]"

    assert models.refusal(EMPTY + entries).splitlines() == [
        'bad.yaml:11: plugins[2] "c": no luck',
        'worse.yaml:9: plugins[0].type: unknown plugin type "Talkr" (did you mean "Talker"?); '
        "there are: Failing, Herald, Talker",
    ]


def test_properties_may_be_empty(models):
    assert models.load("properties:\nlayers: []").physics.body_count == 0
