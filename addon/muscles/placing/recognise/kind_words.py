# SPDX-License-Identifier: GPL-3.0-or-later
"""Words that tell the kind of a creature: parts that only some creatures have, and the names of animals.

A new language needs new words and no code. Words are compared as in `name_words`.
"""

import functools
from collections.abc import Iterable

from .name_words import plain, words_of

PARTS = {
    "quadruped": """hoof hooves paw forepaw hindpaw hock fetlock pastern cannon withers stifle gaskin foreleg forelimb
        hindleg hindlimb forefoot hindfoot horselink mane udder dewclaw huf pfote vorderbein hinterbein vorderpfote
        sabot patte jarret crinière pezuña pata pata zoccolo zampa копыто лапа 蹄 肉球 前足 後足 前脚 後脚 前肢 后肢
        後肢 马蹄 앞다리 뒷다리 발굽""",
    "bird": """beak bill feather feathers plume talon talons wingtip alula primaries secondaries tibiotarsus
        tarsometatarsus schnabel feder plume bec pico pluma bico pena becco piuma клюв перо kuchibashi hane くちばし
        嘴 羽毛 翼 翅膀 부리 깃털""",
    "fish": """fin fins dorsalfin pectoralfin pelvicfin analfin caudalfin tailfin fluke flukes gill gills operculum
        flosse rückenflosse schwanzflosse kieme nageoire ouïe aleta branquia barbatana guelra branchia плавник жабры
        背びれ 尾びれ 鰭 ひれ えら 鳃 鱼鳍 背鳍 지느러미 아가미""",
    "arthropod": """antenna antennae feeler pedipalp pedipalps palp palps chelicera chelicerae mandibles pincer
        pincers stinger carapace cephalothorax prothorax mesothorax metathorax proboscis spinneret spinnerets elytra
        trochanter fühler fuehler stachel antenne mandibule aiguillon antena quelícero aguijón ferrão pungiglione усик
        усики жало shokkaku 触角 觸角 触手肢 더듬이""",
    "other": """tentacle tentacles wheel wheels chassis turret rotor propeller branch trunkbranch leafs tentakel
        tentacule roue tentáculo rueda roda tentacolo ruota щупальце колесо 触手 触腕 車輪 轮子 바퀴""",
}
ANIMALS = {
    "human": """human humanoid man woman male female boy girl person people avatar knight soldier zombie mensch mann
        frau homme femme hombre mujer homem mulher uomo donna человек 人間 人物 人体 사람""",
    "quadruped": """quadruped dog wolf fox cat lion tiger leopard panther cheetah lynx horse pony mare foal donkey
        mule zebra cow bull ox calf bison buffalo sheep goat ram deer stag doe elk moose reindeer antelope gazelle
        camel llama alpaca giraffe elephant rhino rhinoceros hippo hippopotamus pig boar bear rabbit hare mouse rat
        squirrel beaver badger weasel otter hyena jackal coyote puppy kitten hund wolf fuchs katze löwe pferd kuh
        schaf ziege hirsch elefant schwein bär hase maus chien loup renard chat lion cheval vache mouton chèvre cerf
        cochon ours lapin perro lobo zorro gato león caballo vaca oveja cabra ciervo cerdo oso conejo cachorro cavalo
        leão ovelha veado porco urso coelho cane lupo volpe gatto leone cavallo mucca pecora capra cervo maiale orso
        coniglio собака волк лиса кошка лев лошадь корова овца олень свинья медведь inu neko uma kitsune ookami 犬 猫
        馬 狼 狐 牛 羊 鹿 豚 熊 狗 马 猪 老虎 개 고양이 말 늑대 여우""",
    "bird": """bird eagle hawk falcon owl crow raven duck goose swan chicken hen rooster cock parrot penguin pigeon
        dove seagull gull sparrow robin ostrich flamingo stork crane heron pelican peacock turkey vulture vogel adler
        ente eule huhn oiseau aigle canard poule pájaro águila pato pássaro ave uccello aquila anatra птица орёл утка
        tori washi 鳥 鷲 鸟 鹰 鸭 새 독수리""",
    "fish": """fish shark whale dolphin orca tuna salmon trout carp goldfish koi pike cod clownfish piranha fisch hai
        wal delfin poisson requin baleine dauphin pez tiburón ballena delfín peixe tubarão baleia pesce squalo balena
        delfino рыба акула кит дельфин sakana iruka kujira 魚 鮫 鯨 鱼 鲨鱼 물고기 상어 고래""",
    "arthropod": """insect spider ant bee wasp hornet beetle ladybug fly mosquito dragonfly butterfly moth grasshopper
        cricket mantis cockroach scorpion crab lobster shrimp tarantula arachnid insekt spinne ameise biene käfer
        krebs skorpion insecte araignée fourmi abeille crabe insecto araña hormiga abeja cangrejo inseto aranha
        formiga caranguejo insetto ragno formica granchio насекомое паук муравей пчела жук краб kumo kani ari hachi
        蜘蛛 蟻 蜂 虫 蟹 蜘蛛 蚂蚁 昆虫 거미 개미 벌""",
    "other": """snake serpent worm eel octopus squid jellyfish kraken snail slug dragon wyvern dinosaur raptor trex
        kaiju lizard turtle tortoise car truck tank robotarm tree plant schlange krake drache baum tortue serpiente
        pulpo dragón cobra polvo dragão serpente polpo drago змея осьминог дракон hebi tako ryuu 蛇 龍 竜 龙 章鱼 뱀
        문어 용""",
}


@functools.cache
def _kinds(table: str) -> dict[str, str]:
    words = PARTS if table == "parts" else ANIMALS
    return {plain(word): kind for kind, listed in words.items() for word in listed.split()}


def kinds_of_parts(names: Iterable[str]) -> dict[str, set[str]]:
    """The words for parts of each kind of creature that the names of bones contain."""
    return _found(names, _kinds("parts"))


def kinds_of_animals(names: Iterable[str]) -> dict[str, set[str]]:
    """The words for animals of each kind that the names of objects contain."""
    return _found(names, _kinds("animals"))


def _found(names: Iterable[str], kinds: dict[str, str]) -> dict[str, set[str]]:
    found: dict[str, set[str]] = {}
    for name in names:
        words = words_of(name)
        for word in (*words, *("".join(pair) for pair in zip(words, words[1:], strict=False))):
            if word in kinds:
                found.setdefault(kinds[word], set()).add(word)
            elif not word.isascii():
                for known in (known for known in kinds if not known.isascii() and len(known) <= len(word) and known in word):
                    if ord(known[0]) > 0x2FFF:  # scripts without spaces
                        found.setdefault(kinds[known], set()).add(known)
    return found
