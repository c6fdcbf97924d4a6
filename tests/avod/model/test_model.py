"""The network's layers against loops and the published counts and shapes."""

from __future__ import annotations

import dataclasses

import pytest
import torch

from avod.config import Config, ExtractorConfig, PathDropConfig, RefinementConfig
from avod.model.avod.network import AvodNetwork
from avod.model.avod.path_drop import detection_masks, draw_masks, fuse
from avod.model.avod.pyramid import FeaturePyramid
from avod.model.layers import Convolution, Dropout, ShiftBatchNorm, UpConvolution


def count(module: torch.nn.Module) -> int:
    return sum(parameter.numel() for parameter in module.parameters())


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("car_default", 16_682_424),
        ("ped_default", 16_682_424),
        ("car_max3_density3", 16_682_424),
        ("car_max_min_density", 16_682_424 - 864),
        ("people_default", 16_684_473),
        ("all_default", 16_686_522),
    ],
)
def test_the_number_of_parameters_is_the_published_one(name: str, expected: int) -> None:
    network = AvodNetwork(Config.named(name))
    assert count(network) == expected
    if name == "car_default":
        assert count(network.bev_pyramid) == 2_454_880
        assert count(network.image_pyramid) == 2_454_016
        assert count(network.anchor_classifier) + count(network.anchor_regressor) == 138_760
        assert count(network.second_stage) == 11_606_016 + 28_686


@pytest.mark.parametrize(("channels", "size"), [(6, (700, 800)), (3, (360, 1200))])
def test_a_pyramids_stages_have_the_published_shapes(channels: int, size: tuple[int, int]) -> None:
    height, width = size
    padded = -(-height // 8) * 8
    shapes: list[tuple[int, ...]] = []
    with torch.device("meta"):
        pyramid = FeaturePyramid(channels, ExtractorConfig())
        for layer in (*pyramid.encoder, *pyramid.upsample, *pyramid.fuse):
            layer.register_forward_hook(lambda _layer, _inputs, output: shapes.append(tuple(output.shape[1:])))
        out = pyramid(torch.empty((1, channels, height, width)))
    assert out.shape == (1, 32, height, width)
    sizes = [(padded // s, width // s) for s in (1, 2, 4, 8)]
    expected = [(c, *s) for c, s in zip((32, 64, 128, 256), sizes, strict=True)]
    expected += [(128, *sizes[2]), (64, *sizes[2]), (64, *sizes[1]), (32, *sizes[1]), (32, *sizes[0]), (32, *sizes[0])]
    assert shapes == expected


def test_padding_is_on_the_far_side() -> None:
    config = ExtractorConfig(channels=(2, 3), convolutions=(1, 1), fused_channels=(2,))
    torch.manual_seed(0)
    pyramid = FeaturePyramid(1, config).eval()
    inputs = torch.rand((1, 1, 5, 8))
    padded = torch.cat([torch.zeros((1, 1, 1, 8)), inputs], dim=2)
    torch.testing.assert_close(pyramid(inputs), pyramid(padded)[:, :, 1:])


def test_a_transposed_convolution_lays_its_kernel_at_twice_the_place() -> None:
    torch.manual_seed(0)
    layer = UpConvolution(2, 3, ExtractorConfig())
    inputs = torch.rand((1, 2, 4, 5))
    weight = layer.convolution.weight.detach()
    expected = torch.zeros((3, 9, 11))
    for i in range(4):
        for j in range(5):
            for k in range(3):
                for m in range(3):
                    expected[:, 2 * i + k, 2 * j + m] += inputs[0, :, i, j] @ weight[:, :, k, m]
    layer.norm.epsilon = 0.0  # then the first averages, 0 and 1, change nothing
    torch.testing.assert_close(layer.eval()(inputs)[0], expected[:, :8, :10].relu())


@pytest.mark.parametrize("kind", [Convolution, UpConvolution])
def test_in_detection_the_moving_averages_fold_into_the_kernel(kind: type[Convolution] | type[UpConvolution]) -> None:
    layer = kind(3, 5, ExtractorConfig())
    generator = torch.Generator().manual_seed(0)
    norm = layer.norm
    norm.running_mean.normal_(generator=generator)
    norm.running_var.uniform_(0.3, 3.0, generator=generator)
    norm.bias.data.normal_(generator=generator)
    inputs = torch.rand((2, 3, 6, 8), generator=generator)
    plain = layer.convolution(inputs)
    if isinstance(layer, UpConvolution):
        plain = plain[:, :, :-1, :-1]
    torch.testing.assert_close(layer.eval()(inputs), norm.eval()(plain).relu())


def test_normalisation_learns_a_shift_alone_and_averages_slowly() -> None:
    norm = ShiftBatchNorm(3, ExtractorConfig())
    assert [name for name, _ in norm.named_parameters()] == ["bias"]
    norm.bias.data = torch.tensor([0.0, 1.0, 2.0])
    inputs = torch.randn((1, 3, 40, 50), generator=torch.Generator().manual_seed(0)) * 3 + 5
    found = norm(inputs)
    mean, variance = inputs.mean(dim=(0, 2, 3)), inputs.var(dim=(0, 2, 3), correction=0)
    expected = (inputs - mean[:, None, None]) / (variance[:, None, None] + 1e-3).sqrt() + norm.bias[:, None, None]
    torch.testing.assert_close(found, expected, atol=1e-5, rtol=1e-5)
    torch.testing.assert_close(norm.running_mean, 0.001 * mean)
    norm.eval()
    running = (inputs - norm.running_mean[:, None, None]) / (norm.running_var[:, None, None] + 1e-3).sqrt()
    torch.testing.assert_close(norm(inputs), running + norm.bias[:, None, None])


def test_path_drop_has_the_published_frequencies() -> None:
    generator = torch.Generator().manual_seed(0)
    draws = [draw_masks(PathDropConfig(), generator) for _ in range(40_000)]
    shares = {masks: draws.count(masks) / len(draws) for masks in set(draws)}
    assert set(shares) == {(1.0, 1.0), (1.0, 0.0), (0.0, 1.0)}
    assert shares[1.0, 1.0] == pytest.approx(0.81, abs=0.007)
    assert shares[1.0, 0.0] == pytest.approx(0.095, abs=0.006)
    assert shares[0.0, 1.0] == pytest.approx(0.095, abs=0.006)
    always_image = PathDropConfig(keep_image=1.0, keep_bev=0.0)
    assert {draw_masks(always_image, generator) for _ in range(50)} == {(1.0, 0.0)}


@pytest.mark.parametrize(
    ("keep", "masks"),
    [((0.9, 0.9), (1.0, 1.0)), ((1.0, 0.0), (1.0, 0.0)), ((0.0, 0.5), (0.0, 1.0)), ((0.0, 0.0), (1.0, 1.0))],
)
def test_detection_leaves_out_what_training_never_saw(keep: tuple[float, float], masks: tuple[float, float]) -> None:
    assert detection_masks(PathDropConfig(keep_image=keep[0], keep_bev=keep[1])) == masks


def test_fusion_averages_what_is_kept() -> None:
    image, bev = torch.tensor([2.0]), torch.tensor([4.0])
    assert [fuse(image, bev, masks).item() for masks in ((1.0, 1.0), (1.0, 0.0), (0.0, 1.0))] == [3.0, 2.0, 4.0]


def test_dropout_keeps_the_mean_and_leaves_detection_alone() -> None:
    torch.manual_seed(0)
    dropout = Dropout(0.8)
    values = torch.ones((400, 500), dtype=torch.bfloat16)
    found = dropout(values)
    assert found.dtype == values.dtype
    assert (found == 0).float().mean().item() == pytest.approx(0.2, abs=0.005)
    assert set(found.unique().tolist()) == {0.0, 1.25}
    assert torch.equal(dropout.eval()(values), values)
    assert Dropout(1.0)(values) is values


def test_biases_begin_at_zero_and_weights_are_glorots() -> None:
    network = AvodNetwork(dataclasses.replace(Config.named("tiny_car"), refinement=RefinementConfig()))
    for name, parameter in network.named_parameters():
        if parameter.ndim == 1:
            assert (parameter == 0).all(), name
        else:
            field = parameter[0, 0].numel() if parameter.ndim == 4 else 1
            bound = (6.0 / (field * (parameter.shape[0] + parameter.shape[1]))) ** 0.5
            least = 0.9 if parameter.numel() > 100 else 0.5
            assert least * bound < parameter.abs().max() <= bound, name


def test_dropping_channels_of_the_birds_eye_view_changes_its_pyramid_alone() -> None:
    config = Config.named("tiny_car")
    fewer = dataclasses.replace(config, bev=dataclasses.replace(config.bev, num_slices=2))
    shapes = [{name: tuple(p.shape) for name, p in AvodNetwork(c).named_parameters()} for c in (config, fewer)]
    assert {name for name in shapes[0] if shapes[0][name] != shapes[1][name]} == {
        "bev_pyramid.encoder.0.0.convolution.weight"
    }


def test_the_default_is_avods() -> None:
    config = Config()
    assert (config.rpn.train_proposals, config.rpn.proposals, config.rpn.batch_size) == (1024, 300, 512)
    assert (config.rpn.nms_iou, config.detection.nms_iou, config.detection.max_detections) == (0.8, 0.01, 100)
    assert (config.second_stage.batch_size, config.second_stage.gradient) == (1024, "through")


def test_the_first_stage_sees_as_many_channels_of_each_map_as_it_is_told() -> None:
    config = dataclasses.replace(Config(), rpn=dataclasses.replace(Config().rpn, bottleneck_channels=4))
    with torch.device("meta"):
        wide, avods = AvodNetwork(config), AvodNetwork(Config())
    crop, hidden, fused = config.rpn.crop_size**2, config.rpn.hidden, config.extractor.fused_channels[-1]
    # Three more kernels and shifts for each map, three more crops into each of the two heads.
    assert count(wide) - count(avods) == 2 * 3 * (fused + 1) + 2 * 3 * crop * hidden
    assert wide.bev_bottleneck.convolution.out_channels == wide.image_bottleneck.convolution.out_channels == 4
